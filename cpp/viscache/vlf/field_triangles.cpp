#include "viscache/vlf/field_triangles.h"

#include <stdexcept>

namespace viscache {

namespace {

/// Rays that start within this many radii are not moved.
constexpr double kNear = 4;
/// Other rays are moved to this distance, in radii.
constexpr double kEntry = 2;
/// Enlarges the ball beyond the bounding sphere of the triangles, so that corners stay inside after
/// rounding.
constexpr double kFit = 1.0001;

}  // namespace

FieldTriangles::FieldTriangles(std::shared_ptr<const Scene> scene, TriangleKernel kernel, double head_room)
    : scene_(std::move(scene)), kernel_(kernel) {
    FlatTriangles flat = flat_triangles(*scene_);
    degenerate_ = flat.degenerate;
    fit(flat.triangles, flat.bounds, head_room);
    grow(flat.triangles.size());
    for (uint32_t id = 0; id < flat.triangles.size(); ++id) set(id, flat.triangles[id]);
    sources_ = std::move(flat.sources);
    // One test per scene spares the alpha look-up in all others.
    for (uint32_t m = 0; m < scene_->meshes().size(); ++m) cutouts_ |= scene_->has_cutout(m);
}

// Differs (V1): the paper encloses the scene in the cube [−1, 1]³, whose corners leave a rotated square; here
// the bounding sphere is the unit ball.
void FieldTriangles::fit(const std::vector<FlatTriangle>& triangles, const Bounds& bounds, double head_room) {
    if (bounds.empty()) return;
    // In double: a scene far from the origin loses no bits of its size.
    for (int i = 0; i < 3; ++i) space_.center[i] = 0.5 * (double(bounds.lo[i]) + bounds.hi[i]);
    double farthest = 0;
    for (const FlatTriangle& t : triangles)
        for (const Vec3 p : {t.a, t.b, t.c}) {
            double sum = 0;
            for (int i = 0; i < 3; ++i) sum += (p[i] - space_.center[i]) * (p[i] - space_.center[i]);
            farthest = std::max(farthest, sum);
        }
    if (farthest > 0) space_.radius = std::sqrt(farthest) * kFit * head_room;
    // The kernels work relative to this point (0 unless the scene is far from the origin).
    origin_ = exact_origin(bounds);
}

Vec3 FieldTriangles::to_ball(Vec3 p) const {
    const double s = 1 / space_.radius, *c = space_.center;
    return {float((p.x - c[0]) * s), float((p.y - c[1]) * s), float((p.z - c[2]) * s)};
}

bool FieldTriangles::holds(const FlatTriangle& t) const {
    // Projected corners of such a triangle lie on the tiles of every direction.
    const auto inside = [&](Vec3 p) { return length2(to_ball(p)) <= 1; };
    return inside(t.a) && inside(t.b) && inside(t.c);
}

void FieldTriangles::grow(size_t count) {
    const size_t n = in_ball_.size() + count;
    if (n >= kNoHit) throw std::length_error("a field holds at most 2^32 - 2 triangles");
    in_ball_.resize(n);
    // Triangles of objects have no source in the scene; `solid` takes them as opaque.
    sources_.resize(n, {kNoHit, kNoHit, kNoHit});
    if (kernel_ == TriangleKernel::kWald)
        wald_.resize(n);
    else
        corners_.resize(n);
}

void FieldTriangles::set(uint32_t id, const FlatTriangle& t) {
    // Two copies: in the unit ball, for lists; relative to the origin, in scene units, for the kernel.
    in_ball_[id] = {to_ball(t.a), to_ball(t.b), to_ball(t.c)};
    const Vec3 a = t.a - origin_, b = t.b - origin_, c = t.c - origin_;
    if (kernel_ == TriangleKernel::kWald)
        wald_[id] = wald_triangle(a, b, c, id);
    else
        corners_[id] = {a, b, c, id, {}};
}

uint64_t FieldTriangles::bytes() const {
    // Records of both kernels have the same size.
    return size() * (sizeof(TriangleSource) + sizeof(FlatTriangle) + sizeof(WaldTriangle));
}

LocalRay FieldTriangles::to_local(const Ray& ray, const FieldRay& in_ball) const {
    const double *o = in_ball.o, *d = in_ball.d;
    const double from2 = o[0] * o[0] + o[1] * o[1] + o[2] * o[2];
    // Near rays stay as they are: their answers have the bits of the kernel in scene space.
    if (from2 <= kNear * kNear) return {{ray.o - origin_, ray.t_min, ray.d, ray.t_max}, 0};
    const double d2 = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
    // Closest approach to the centre, and its squared distance. The ray then starts where it enters the
    // sphere of radius kEntry, or at the closest approach if it misses it:
    //
    //     o ------------ shift ----------->(-------- nearest        )
    //                                      ^ entry of the sphere of radius kEntry
    const double nearest = -(o[0] * d[0] + o[1] * d[1] + o[2] * d[2]) / d2;
    double apart2 = 0;
    for (int i = 0; i < 3; ++i) apart2 += (o[i] + nearest * d[i]) * (o[i] + nearest * d[i]);
    const double shift = nearest - std::sqrt(std::max(0.0, kEntry * kEntry - apart2) / d2);
    // In double, and rounded once: the far origin and the shift nearly cancel.
    const auto moved = [&](float origin, float direction, float local) {
        return float(double(origin) + shift * direction - local);
    };
    return {{{moved(ray.o.x, ray.d.x, origin_.x), moved(ray.o.y, ray.d.y, origin_.y),
              moved(ray.o.z, ray.d.z, origin_.z)},
             float(ray.t_min - shift),
             ray.d,
             float(ray.t_max - shift)},
            shift};
}

Hit FieldTriangles::hit(const NearestHit& best) const {
    if (best.id == kNoHit) return {};
    const TriangleSource& from = sources_[best.id];
    return {best.t, from.mesh, from.triangle, from.instance, best.u, best.v};
}

}  // namespace viscache

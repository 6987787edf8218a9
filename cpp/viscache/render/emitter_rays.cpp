#include "viscache/render/emitter_rays.h"

#include <array>

#include "viscache/scene/light_tree.h"

namespace viscache {

namespace {

/// Up to this many lights are tested one by one. The tree bounds more.
constexpr size_t kFewLightsToTest = 16;

struct Nearest {
    size_t light = 0;
    float t = kInfinity;
    float u = 0, v = 0;  ///< barycentric coordinates on a triangle
};

/// Möller and Trumbore 1997.
void meet(const EmissiveTriangle& t, const Ray& ray, size_t light, Nearest& nearest) {
    // A light with holes would need its texture here; light samples alone find it, with weight one
    if (!t.opaque) return;
    const Vec3 e1 = t.b - t.a, e2 = t.c - t.a, p = cross(ray.d, e2);
    // A ray along the plane has det = 0, and the comparisons below refuse what is not finite
    const float det = dot(e1, p);
    const Vec3 s = ray.o - t.a, q = cross(s, e1);
    const float u = dot(s, p) / det, v = dot(ray.d, q) / det, distance = dot(e2, q) / det;
    if (u >= 0 && v >= 0 && u + v <= 1 && distance > ray.t_min && distance < nearest.t)
        nearest = {light, distance, u, v};
}

void meet(const SphereLight& s, const Ray& ray, size_t light, Nearest& nearest) {
    // In double: far from a small sphere, r² and the squared distance cancel to nothing in float
    const double x = double(ray.o.x) - s.center.x, y = double(ray.o.y) - s.center.y;
    const double z = double(ray.o.z) - s.center.z, r = s.radius;
    // Along the ray, and squared beside it. The ray meets the sphere where it passes nearer than
    // the radius
    const double along = x * ray.d.x + y * ray.d.y + z * ray.d.z;
    const double aside2 = x * x + y * y + z * z - along * along;
    if (!(aside2 < r * r)) return;
    const double half = std::sqrt(r * r - aside2);
    // From inside, the nearer one lies behind the origin
    for (const double t : {-along - half, -along + half})
        if (t > double(ray.t_min) && t < double(nearest.t)) {
            nearest = {light, float(t)};
            return;
        }
}

void meet(const AreaLights& lights, size_t light, const Ray& ray, Nearest& nearest) {
    const size_t triangles = lights.triangles.size();
    if (light < triangles)
        meet(lights.triangles[light], ray, light, nearest);
    else
        meet(lights.spheres[light - triangles], ray, light, nearest);
}

/// Distance at which the ray enters a box, widened for rounding; infinity if it misses.
float entry(const Bounds& box, Vec3 origin, Vec3 inverse, float t_max) {
    // Slab test: the ray is inside of the box between the last entry and the first exit of the
    // three axes
    float near = 0, far = t_max;
    for (int axis = 0; axis < 3; ++axis) {
        // The product below would be 0·∞, which is NaN
        if (!std::isfinite(inverse[axis])) {  // along the planes of the box
            if (origin[axis] < box.lo[axis] || origin[axis] > box.hi[axis]) return kInfinity;
            continue;
        }
        const float a = (box.lo[axis] - origin[axis]) * inverse[axis];
        const float b = (box.hi[axis] - origin[axis]) * inverse[axis];
        near = std::max(near, std::min(a, b));
        far = std::min(far, std::max(a, b));
    }
    // A relative 1e-5 is over a hundred roundings of float, so no light in a box is missed by those
    // of the slabs
    return near <= far * 1.00001f ? near : kInfinity;
}

void descend(const LightTree& tree, const AreaLights& lights, const Ray& ray, Nearest& nearest) {
    const Vec3 inverse{1 / ray.d.x, 1 / ray.d.y, 1 / ray.d.z};
    struct Entry {
        uint32_t node;
        float near;
    };
    // The nearer child first: a hit there often removes the farther one, which waits with its
    // distance
    std::array<Entry, LightTree::kMostWaiting> stack;
    size_t size = 0;
    const auto& nodes = tree.nodes();
    stack[size++] = {0, entry(nodes[0].box, ray.o, inverse, nearest.t)};
    while (size > 0) {
        const Entry at = stack[--size];
        // A hit since it was put here may be nearer
        if (!(at.near < nearest.t)) continue;
        const LightTree::Node& node = nodes[at.node];
        if (node.leaf) {
            meet(lights, node.other, ray, nearest);
            continue;
        }
        Entry first{at.node + 1, entry(nodes[at.node + 1].box, ray.o, inverse, nearest.t)};
        Entry second{node.other, entry(nodes[node.other].box, ray.o, inverse, nearest.t)};
        if (second.near < first.near) std::swap(first, second);
        if (second.near < nearest.t) stack[size++] = second;
        if (first.near < nearest.t) stack[size++] = first;
    }
}

}  // namespace

bool can_be_hit(const AreaLights& lights, size_t light) {
    return light >= lights.triangles.size() || lights.triangles[light].opaque;
}

std::optional<EmitterHit> nearest_emitter(const Scene& scene, const Ray& ray) {
    const AreaLights& lights = scene.area_lights();
    Nearest nearest;
    nearest.t = ray.t_max;
    // One past the last: nothing found yet
    nearest.light = lights.size();
    if (lights.size() <= kFewLightsToTest)
        for (size_t i = 0; i < lights.size(); ++i) meet(lights, i, ray, nearest);
    else
        descend(scene.light_tree(), lights, ray, nearest);
    if (nearest.light == lights.size()) return std::nullopt;
    if (nearest.light < lights.triangles.size()) {
        const EmissiveTriangle& t = lights.triangles[nearest.light];
        // One-sided lights keep their normal, so that the caller sees that the emitting side faces
        // away
        const bool behind = dot(t.normal, ray.d) > 0;
        return EmitterHit{nearest.light,
                          t.a + (t.b - t.a) * nearest.u + (t.c - t.a) * nearest.v,
                          behind && t.two_sided ? -t.normal : t.normal,
                          {nearest.u, nearest.v}};
    }
    const SphereLight& s = lights.spheres[nearest.light - lights.triangles.size()];
    // The point is put back onto the sphere: its density divides by a cosine, which rounding along
    // a long ray would spoil
    const Vec3 n = normalize(ray.o + ray.d * nearest.t - s.center);
    return EmitterHit{nearest.light, s.center + n * s.radius, n, {}};
}

}  // namespace viscache

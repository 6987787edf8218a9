#include "viscache/casters/watertight_caster.h"

#include <bit>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "viscache/casters/embree.h"
#include "viscache/casters/flat_triangles.h"
#include "viscache/casters/triangle_kernels.h"

namespace viscache {

namespace {

/// Boxes grow by this share of the scene's radius. For rays that start within kNear radii, Embree's test of
/// boxes and our test of triangles are each wrong by at most 2e-6 radii.
constexpr float kSlack = 1e-5f;
/// Rays that start within this many radii are not moved.
constexpr double kNear = 4;
/// Other rays are moved to this distance, in radii.
constexpr double kEntry = 2;
/// Directions whose largest component leaves [1 / kLongest, kLongest] are scaled. Embree replaces components
/// below 1e-18.
constexpr float kLongest = 1 << 20;

/// A ray relative to the origin of the triangles: t of the caller = (t + shift) · 2^exponent.
struct LocalRay {
    Ray ray;
    double shift = 0;
    int exponent = 0;
};

/// What Embree's callbacks know of the ray that is traced.
struct Search {
    ShearedRay ray;
    NearestHit best;
};

}  // namespace

struct WatertightCaster::Impl {
    const Scene* scene = nullptr;
    std::vector<WatertightTriangle> triangles;
    std::vector<TriangleSource> sources;
    bool cutouts = false;
    Vec3 origin;            ///< subtracted from rays and triangles; nonzero only far from the origin
    double center[3] = {};  ///< of the triangles, after the subtraction
    double radius = 0;
    RTCScene top = nullptr;

    explicit Impl(const Scene& of);
    ~Impl() {
        if (top) rtcReleaseScene(top);
    }
    std::optional<LocalRay> to_local(const Ray& ray) const;
    Hit nearest(const Ray& ray) const;
    bool any(const Ray& ray) const;
    /// Takes a triangle if it is the nearest hit so far.
    bool take(uint32_t id, Search& search) const {
        TriangleHit hit;
        if (!intersect_watertight(triangles[id], search.ray, search.best.t, hit)) return false;
        if (!search.best.nearer(hit, id)) return false;
        if (cutouts && !scene->solid_at(sources[id].mesh, sources[id].triangle, hit.u, hit.v)) return false;
        search.best.take(hit, id);
        return true;
    }

private:
    void fit(const Bounds& bounds);
    void build();
};

void WatertightCaster::Impl::fit(const Bounds& bounds) {
    origin = exact_origin(bounds);
    double sum = 0;
    for (int i = 0; i < 3; ++i) {
        center[i] = 0.5 * (double(bounds.lo[i]) + bounds.hi[i]) - origin[i];
        sum += std::pow(0.5 * (double(bounds.hi[i]) - bounds.lo[i]), 2);
    }
    radius = std::sqrt(sum);
}

WatertightCaster::Impl::Impl(const Scene& of) : scene(&of) {
    FlatTriangles flat = flat_triangles(of);
    if (flat.triangles.empty()) return;
    fit(flat.bounds);
    triangles.reserve(flat.triangles.size());
    for (const FlatTriangle& t : flat.triangles)
        triangles.push_back({t.a - origin, t.b - origin, t.c - origin, uint32_t(triangles.size()), {}});
    sources = std::move(flat.sources);
    for (uint32_t m = 0; m < of.meshes().size(); ++m) cutouts |= of.has_cutout(m);
    build();
}

void WatertightCaster::Impl::build() {
    const RTCDevice device = rtc::shared_device();
    top = rtcNewScene(device);
    RTCGeometry g = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
    rtcSetGeometryUserPrimitiveCount(g, unsigned(triangles.size()));
    rtcSetGeometryUserData(g, this);
    rtcSetGeometryMask(g, 0xffffffffu);
    rtcSetGeometryBoundsFunction(
        g,
        [](const RTCBoundsFunctionArguments* args) {
            const auto& impl = *static_cast<const Impl*>(args->geometryUserPtr);
            const WatertightTriangle& t = impl.triangles[args->primID];
            const Vec3 lo = min(min(t.a, t.b), t.c), hi = max(max(t.a, t.b), t.c);
            const float slack = float(kSlack * impl.radius);
            RTCBounds& box = *args->bounds_o;
            box.lower_x = lo.x - slack;
            box.lower_y = lo.y - slack;
            box.lower_z = lo.z - slack;
            box.upper_x = hi.x + slack;
            box.upper_y = hi.y + slack;
            box.upper_z = hi.z + slack;
        },
        nullptr);
    // Rays are traced one by one, so N = 1
    rtcSetGeometryIntersectFunction(g, [](const RTCIntersectFunctionNArguments* args) {
        if (args->valid[0] != -1) return;
        auto& search = *static_cast<Search*>(rtc::Query::data_of(args->context));
        if (!static_cast<const Impl*>(args->geometryUserPtr)->take(args->primID, search)) return;
        auto& found = *reinterpret_cast<RTCRayHit*>(args->rayhit);
        found.ray.tfar = search.best.t;
        found.hit.geomID = args->geomID;
    });
    rtcSetGeometryOccludedFunction(g, [](const RTCOccludedFunctionNArguments* args) {
        if (args->valid[0] != -1) return;
        auto& search = *static_cast<Search*>(rtc::Query::data_of(args->context));
        if (!static_cast<const Impl*>(args->geometryUserPtr)->take(args->primID, search)) return;
        reinterpret_cast<RTCRay*>(args->ray)->tfar = -kInfinity;
    });
    rtcCommitGeometry(g);
    rtcAttachGeometry(top, g);
    rtcReleaseGeometry(g);
    rtcCommitScene(top);
    rtc::require_built();
}

/// Nothing if the ray cannot hit anything.
std::optional<LocalRay> WatertightCaster::Impl::to_local(const Ray& ray) const {
    if (triangles.empty() || ray.d == Vec3{} || !(ray.t_max > ray.t_min)) return std::nullopt;
    LocalRay local{{ray.o - origin, ray.t_min, ray.d, ray.t_max}};
    Ray& r = local.ray;
    const float longest = max_abs(ray.d);
    if (longest < 1 / kLongest || longest > kLongest) {
        local.exponent = -std::ilogb(longest);
        // Each by itself: the factor of a direction below 2^-127 is no float
        const auto scaled = [&](float v) { return std::ldexp(v, local.exponent); };
        r.d = {scaled(ray.d.x), scaled(ray.d.y), scaled(ray.d.z)};
        r.t_min = std::ldexp(ray.t_min, -local.exponent);
        r.t_max = std::ldexp(ray.t_max, -local.exponent);
    }
    double o[3], from2 = 0, towards = 0, d2 = 0;
    for (int i = 0; i < 3; ++i) {
        o[i] = double(ray.o[i]) - origin[i] - center[i];
        from2 += o[i] * o[i];
        towards -= o[i] * r.d[i];
        d2 += double(r.d[i]) * r.d[i];
    }
    if (from2 <= kNear * kNear * radius * radius) return local;
    if (towards <= 0) return std::nullopt;
    const double nearest = towards / d2, apart2 = from2 - nearest * towards;
    const double enter = kEntry * kEntry * radius * radius - apart2;
    local.shift = nearest - std::sqrt(std::max(0.0, enter) / d2);
    for (int i = 0; i < 3; ++i) (&r.o.x)[i] = float(o[i] + center[i] + local.shift * r.d[i]);
    r.t_min = float(std::max(0.0, r.t_min - local.shift));
    r.t_max = float(r.t_max - local.shift);
    if (!(r.t_max > r.t_min)) return std::nullopt;
    return local;
}

Hit WatertightCaster::Impl::nearest(const Ray& ray) const {
    const auto local = to_local(ray);
    if (!local) return {};
    const Ray& r = local->ray;
    Search search{ShearedRay(r), NearestHit{r.t_max}};
    rtc::Query query(Coherence::kIncoherent, &search);
    RTCRayHit h{};
    h.ray = {r.o.x, r.o.y, r.o.z, r.t_min, r.d.x, r.d.y, r.d.z, 0, r.t_max, ~0u, 0, 0};
    h.hit.geomID = h.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    query.intersect1(top, h);
    const NearestHit& best = search.best;
    if (best.id == kNoHit) return {};
    const float t = local->shift == 0 ? best.t : float(best.t + local->shift);
    const TriangleSource& from = sources[best.id];
    return {std::min(std::ldexp(t, local->exponent), std::numeric_limits<float>::max()),
            from.mesh,
            from.triangle,
            from.instance,
            best.u,
            best.v};
}

bool WatertightCaster::Impl::any(const Ray& ray) const {
    const auto local = to_local(ray);
    if (!local) return false;
    const Ray& r = local->ray;
    Search search{ShearedRay(r), NearestHit{r.t_max}};
    rtc::Query query(Coherence::kIncoherent, &search);
    RTCRay h{r.o.x, r.o.y, r.o.z, r.t_min, r.d.x, r.d.y, r.d.z, 0, r.t_max, ~0u, 0, 0};
    query.occluded1(top, h);
    return search.best.id != kNoHit;
}

WatertightCaster::WatertightCaster(std::shared_ptr<const Scene> scene)
    : scene_(std::move(scene)), impl_(std::make_unique<Impl>(*scene_)) {}

WatertightCaster::~WatertightCaster() = default;

void WatertightCaster::intersect(std::span<const Ray> rays, std::span<Hit> hits, Coherence) const {
    for (size_t i = 0; i < rays.size(); ++i) hits[i] = impl_->nearest(rays[i]);
}

void WatertightCaster::occluded(std::span<const Ray> rays, std::span<uint8_t> occluded) const {
    for (size_t i = 0; i < rays.size(); ++i) occluded[i] = impl_->any(rays[i]);
}

uint16_t WatertightCaster::occluded16(uint16_t mask, RayPacket16& p, Coherence) const {
    uint32_t answer = 0;
    for (uint32_t left = mask; left; left &= left - 1) {
        const int i = std::countr_zero(left);
        answer |= uint32_t(impl_->any(p.ray(size_t(i)))) << i;
    }
    return uint16_t(answer);
}

}  // namespace viscache

#include "viscache/casters/embree_caster.h"

#include <cstring>
#include <limits>
#include <map>

#include "viscache/casters/embree_packets.h"

namespace viscache {

/// Data of a geometry for its filter callback.
struct GeometryData {
    const Scene* scene;
    uint32_t mesh;
};

namespace {

static_assert(sizeof(RTCRay16) >= sizeof(RayPacket16));

using rtc::shared_device;

/// Rejects hits where the alpha of the material cuts a hole.
void cutout_filter(const RTCFilterFunctionNArguments* args) {
    const auto* data = static_cast<const GeometryData*>(args->geometryUserPtr);
    for (unsigned i = 0; i < args->N; ++i) {
        if (args->valid[i] != -1) continue;
        const uint32_t triangle = RTCHitN_primID(args->hit, args->N, i);
        const float u = RTCHitN_u(args->hit, args->N, i), v = RTCHitN_v(args->hit, args->N, i);
        if (!data->scene->solid_at(data->mesh, triangle, u, v)) args->valid[i] = 0;
    }
}

/// For every distinct list of meshes, the least stretch of its instances.
///
/// A ray enters an instance through the inverse of its transform. If the inverse enlarges, coordinates can
/// exceed what Embree's asserts allow; if it shrinks, squared lengths can underflow. Therefore meshes are
/// stored at the size of their smallest instance. Then no inverse enlarges by more than the anisotropy of
/// its transform, and the limits on coordinates also hold inside instances. Scales are powers of two, so
/// they change no digit.
std::map<std::vector<int>, double> least_stretches(const std::vector<Instance>& instances) {
    std::map<std::vector<int>, double> least;
    for (const Instance& instance : instances) {
        const double stretch = instance.to_world.least_stretch();
        const auto [found, is_new] = least.try_emplace(instance.meshes, stretch);
        if (!is_new) found->second = std::min(found->second, stretch);
    }
    return least;
}

/// Distance of a hit whose t overflowed in Embree, in double: from the other end of the range of coordinates,
/// or along a direction of next to no length.
float distance_in_double(const Scene& scene, const Ray& ray, const Hit& hit) {
    const Mesh& mesh = scene.meshes()[hit.mesh];
    const Vec3u corners = mesh.triangles[hit.triangle];
    const double weights[3] = {1.0 - hit.u - hit.v, hit.u, hit.v};
    const uint32_t ids[3] = {corners.x, corners.y, corners.z};
    double along = 0, length2 = 0;
    for (int axis = 0; axis < 3; ++axis) {
        double at = 0;
        for (int i = 0; i < 3; ++i) {
            const Vec3 p = mesh.vertices[ids[i]];
            at += weights[i] * (hit.instance == kNoHit
                                    ? p
                                    : scene.description().instances[hit.instance].to_world.point(p))[axis];
        }
        along += (at - ray.o[axis]) * ray.d[axis];
        length2 += double(ray.d[axis]) * ray.d[axis];
    }
    const double t = along / length2;
    return t > ray.t_min ? float(std::min(t, double(std::numeric_limits<float>::max()))) : ray.t_min;
}

float power_of_two_below(double x) { return std::ldexp(1.f, std::ilogb(x)); }

}  // namespace

struct EmbreeCaster::Impl {
    RTCScene top = nullptr;
    bool native16 = rtcGetDeviceProperty(shared_device(), RTC_DEVICE_PROPERTY_NATIVE_RAY16_SUPPORTED) != 0;
    std::vector<RTCScene> groups;
    std::vector<GeometryData> data;                // one per mesh; never reallocated after construction
    std::vector<uint32_t> top_mesh, top_instance;  // mesh, or instance, of each geomID of the top scene
    std::vector<std::vector<uint32_t>> group_mesh, instance_mesh;

    ~Impl() {
        if (top) rtcReleaseScene(top);
        for (RTCScene s : groups) rtcReleaseScene(s);
    }
    RTCScene new_scene(bool robust) const {
        RTCScene s = rtcNewScene(shared_device());
        rtcSetSceneFlags(s, robust ? RTC_SCENE_FLAG_ROBUST : RTC_SCENE_FLAG_NONE);
        return s;
    }
    /// Attaches a mesh; its vertices are multiplied by `scale`.
    unsigned attach_mesh(RTCScene target, const Scene& scene, uint32_t index, float scale = 1);
    /// Attaches an instance of a group whose vertices were multiplied by `scale`.
    void attach_instance(const Instance& instance, RTCScene group, float scale, uint32_t index);
    /// True if packets of 16 are safe. On AVX-512, Embree compiled by g++ can loop forever over a coherent
    /// packet of 16 that enters an instance, because its mask contains stray high bits of a register (Embree
    /// pull request 574; observed with 3.13.5 after incoherent packets of 16). Packets of 8 are safe.
    bool sound16(Coherence coherence) const { return groups.empty() || coherence == Coherence::kIncoherent; }
    PacketPlan sound(PacketPlan plan) const {
        if (plan.width == 16 && !sound16(plan.coherence)) plan.width = 8;
        return plan;
    }
    Hit hit_of(unsigned geom, unsigned inst, unsigned prim, float u, float v, float t) const;
};

unsigned EmbreeCaster::Impl::attach_mesh(RTCScene target, const Scene& scene, uint32_t index, float scale) {
    const Mesh& mesh = scene.meshes()[index];
    RTCGeometry g = rtcNewGeometry(shared_device(), RTC_GEOMETRY_TYPE_TRIANGLE);
    if (!mesh.triangles.empty()) {
        // New buffers instead of shared ones: Embree pads them for its 16-byte loads.
        void* v = rtcSetNewGeometryBuffer(g, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, sizeof(Vec3),
                                          mesh.vertices.size());
        void* t = rtcSetNewGeometryBuffer(g, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, sizeof(Vec3u),
                                          mesh.triangles.size());
        if (!v || !t) throw std::bad_alloc();
        std::transform(mesh.vertices.begin(), mesh.vertices.end(), static_cast<Vec3*>(v),
                       [&](Vec3 p) { return p * scale; });
        std::memcpy(t, mesh.triangles.data(), mesh.triangles.size() * sizeof(Vec3u));
    }
    rtcSetGeometryMask(g, 0xffffffffu);
    if (scene.has_cutout(index)) {
        rtcSetGeometryUserData(g, &data[index]);
        rtcSetGeometryIntersectFilterFunction(g, cutout_filter);
        rtcSetGeometryOccludedFilterFunction(g, cutout_filter);
    }
    rtcCommitGeometry(g);
    const unsigned id = rtcAttachGeometry(target, g);
    rtcReleaseGeometry(g);
    return id;
}

void EmbreeCaster::Impl::attach_instance(const Instance& instance, RTCScene group, float scale,
                                         uint32_t index) {
    RTCGeometry g = rtcNewGeometry(shared_device(), RTC_GEOMETRY_TYPE_INSTANCE);
    rtcSetGeometryInstancedScene(g, group);
    rtcSetGeometryTimeStepCount(g, 1);
    float m[12];  // column-major 3×4
    for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 4; ++c) m[3 * c + r] = float(instance.to_world.m[r][c] / (c < 3 ? scale : 1));
    rtcSetGeometryTransform(g, 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, m);
    rtcSetGeometryMask(g, 0xffffffffu);
    rtcCommitGeometry(g);
    const unsigned id = rtcAttachGeometry(top, g);
    rtcReleaseGeometry(g);
    top_mesh.resize(id + 1, kNoHit);
    top_instance.resize(id + 1, kNoHit);
    top_instance[id] = index;
}

Hit EmbreeCaster::Impl::hit_of(unsigned geom, unsigned inst, unsigned prim, float u, float v, float t) const {
    Hit hit;
    if (geom == RTC_INVALID_GEOMETRY_ID) return hit;
    hit.t = t;
    hit.u = u;
    hit.v = v;
    hit.triangle = prim;
    if (inst == RTC_INVALID_GEOMETRY_ID) {
        hit.mesh = top_mesh[geom];
    } else {
        hit.instance = top_instance[inst];
        hit.mesh = instance_mesh[hit.instance][geom];
    }
    return hit;
}

/// Packets of rays are wider than what coherent traversal suits from so many triangle sizes on. Fitted to 180
/// cases: twenty built-in scenes at three resolutions (docs/performance/exact.md).
static constexpr float kCoherentTriangles = 6;

EmbreeCaster::EmbreeCaster(std::shared_ptr<const Scene> scene, EmbreeOptions options)
    : scene_(std::move(scene)),
      impl_(std::make_unique<Impl>()),
      coherent_width_(kCoherentTriangles * scene_->triangle_size()) {
    Impl& impl = *impl_;
    const auto& meshes = scene_->meshes();
    for (uint32_t i = 0; i < meshes.size(); ++i) impl.data.push_back({scene_.get(), i});
    impl.top = impl.new_scene(options.robust);
    for (uint32_t i = 0; i < meshes.size(); ++i) {
        if (!meshes[i].in_world || meshes[i].triangles.empty()) continue;
        const unsigned id = impl.attach_mesh(impl.top, *scene_, i);
        impl.top_mesh.resize(id + 1, kNoHit);
        impl.top_instance.resize(id + 1, kNoHit);
        impl.top_mesh[id] = i;
    }
    // One Embree scene per distinct list of meshes, shared by its instances.
    std::map<std::vector<int>, size_t> group_of;
    std::vector<float> group_scale;
    const auto& instances = scene_->description().instances;
    const auto least = least_stretches(instances);
    for (uint32_t i = 0; i < instances.size(); ++i) {
        auto [found, is_new] = group_of.try_emplace(instances[i].meshes, impl.groups.size());
        if (is_new) {
            impl.groups.push_back(impl.new_scene(options.robust));
            impl.group_mesh.emplace_back();
            group_scale.push_back(power_of_two_below(least.at(instances[i].meshes)));
            for (int mesh : instances[i].meshes) {
                if (meshes[size_t(mesh)].triangles.empty()) continue;
                const unsigned id =
                    impl.attach_mesh(impl.groups.back(), *scene_, uint32_t(mesh), group_scale.back());
                impl.group_mesh.back().resize(id + 1, kNoHit);
                impl.group_mesh.back()[id] = uint32_t(mesh);
            }
            rtcCommitScene(impl.groups.back());
        }
        impl.attach_instance(instances[i], impl.groups[found->second], group_scale[found->second], i);
        impl.instance_mesh.push_back(impl.group_mesh[found->second]);
    }
    rtcCommitScene(impl.top);
    rtc::require_built();
}

EmbreeCaster::~EmbreeCaster() = default;

std::string EmbreeCaster::version() {
    const auto number = [](RTCDeviceProperty p) {
        return std::to_string(rtcGetDeviceProperty(shared_device(), p));
    };
    return number(RTC_DEVICE_PROPERTY_VERSION_MAJOR) + "." + number(RTC_DEVICE_PROPERTY_VERSION_MINOR) + "." +
           number(RTC_DEVICE_PROPERTY_VERSION_PATCH);
}

void EmbreeCaster::intersect(std::span<const Ray> rays, std::span<Hit> hits, Coherence coherence) const {
    const auto hit_of = [&](auto... answer) { return impl_->hit_of(answer...); };
    rtc::Query query(coherence);
    if (impl_->sound16(coherence))
        rtc::nearest_packets<RTCRayHit16, 16>(query, impl_->top, rays, hits, hit_of);
    else
        rtc::nearest_packets<RTCRayHit8, 8>(query, impl_->top, rays, hits, hit_of);
    for (size_t i = 0; i < rays.size(); ++i)
        if (hits[i].valid() && !std::isfinite(hits[i].t))
            hits[i].t = distance_in_double(*scene_, rays[i], hits[i]);
}

void EmbreeCaster::intersect_singly(std::span<const Ray> rays, std::span<Hit> hits) const {
    rtc::Query query(Coherence::kIncoherent);
    for (size_t i = 0; i < rays.size(); ++i) {
        const Ray& r = rays[i];
        hits[i] = {};
        if (!(r.t_max > r.t_min)) continue;
        RTCRayHit h{};
        h.ray = {r.o.x, r.o.y, r.o.z, r.t_min, r.d.x, r.d.y, r.d.z, 0, r.t_max, ~0u, 0, 0};
        h.hit.geomID = h.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
        query.intersect1(impl_->top, h);
        hits[i] = impl_->hit_of(h.hit.geomID, h.hit.instID[0], h.hit.primID, h.hit.u, h.hit.v, h.ray.tfar);
    }
}

uint16_t EmbreeCaster::occluded16(uint16_t mask, RayPacket16& rays, Coherence coherence) const {
    rtc::Query query(coherence);
    const RTCScene top = impl_->top;
    // Incoherent packets of 16 would take 3 to 10 % less time, but some of their answers depend on the other
    // rays (docs/performance/tried.md). Without AVX-512, Embree would have to sort a packet of 16 again.
    if (impl_->native16 && coherence == Coherence::kCoherent && impl_->sound16(coherence))
        return uint16_t(rtc::occluded_lanes<RTCRay16, 16>(query, top, mask, rays, 0));
    uint32_t occluded = 0;
    if (mask & 0xff) occluded = rtc::occluded_lanes<RTCRay8, 8>(query, top, mask & 0xffu, rays, 0);
    if (mask >> 8) occluded |= rtc::occluded_lanes<RTCRay8, 8>(query, top, uint32_t(mask >> 8), rays, 8) << 8;
    return uint16_t(occluded);
}

void EmbreeCaster::occluded(std::span<const Ray> rays, std::span<uint8_t> occluded) const {
    for (size_t first = 0; first < rays.size(); first += 16) {
        const size_t n = std::min<size_t>(16, rays.size() - first);
        RayPacket16 packet;
        for (size_t i = 0; i < 16; ++i) packet.set(i, rays[first + std::min(i, n - 1)]);
        const uint16_t bits =
            occluded16(uint16_t(n == 16 ? 0xffff : (1 << n) - 1), packet, Coherence::kIncoherent);
        for (size_t i = 0; i < n; ++i) occluded[first + i] = bits >> i & 1;
    }
}

void EmbreeCaster::occluded(const RayBatch& batch, uint8_t* blocked, const PacketPlan& plan) const {
    rtc::Query query(plan.coherence);
    const auto run = rtc::is_wide(impl_->sound(plan)) ? rtc::occluded_batch<RTCRay16, 16>
                                                      : rtc::occluded_batch<RTCRay8, 8>;
    run(query, impl_->top, batch, blocked);
}

void EmbreeCaster::occluded_in_a_loop(const RayArrays& rays, size_t first, size_t count, uint8_t* occluded,
                                      const PacketPlan& plan) const {
    rtc::occluded_by_plan(impl_->top, rays, first, count, occluded, impl_->sound(plan));
}

void EmbreeCaster::blocked_along(const PointLanes& points, Vec3 axis, float t_max, uint16_t* blocked,
                                 const PacketPlan& plan) const {
    rtc::Query query(plan.coherence);
    const auto run =
        rtc::is_wide(impl_->sound(plan)) ? rtc::trace_along<RTCRay16, 16> : rtc::trace_along<RTCRay8, 8>;
    run(query, impl_->top, points, axis, t_max, blocked);
}

void EmbreeCaster::blocked_from(Vec3 origin, Vec3 normal, const AxisLanes& axes, float t_max, Word* blocked,
                                const PacketPlan& plan) const {
    rtc::Query query(plan.coherence);
    const auto run =
        rtc::is_wide(impl_->sound(plan)) ? rtc::trace_from<RTCRay16, 16> : rtc::trace_from<RTCRay8, 8>;
    run(query, impl_->top, origin, normal, axes, t_max, blocked);
}

bool EmbreeCaster::native16() const { return impl_->native16; }

}  // namespace viscache

#include "viscache/visibility/embree_caster.h"

#include <cstring>
#include <map>
#include <stdexcept>

#include "viscache/visibility/embree.h"

namespace viscache {

namespace {

static_assert(sizeof(RTCRay16) >= sizeof(RayPacket16));

/// One Embree device for the process.
RTCDevice shared_device() {
    static const RTCDevice device = [] {
        RTCDevice d = rtcNewDevice(nullptr);
        if (!d) throw std::runtime_error("Embree could not be started: error " + std::to_string(rtcGetDeviceError(nullptr)));
        return d;
    }();
    return device;
}

/// What a filter callback needs to know about its geometry.
struct GeometryData {
    const Scene* scene;
    uint32_t mesh;
};

/// Rejects hits where the material's alpha cuts a hole.
void cutout_filter(const RTCFilterFunctionNArguments* args) {
    const auto* data = static_cast<const GeometryData*>(args->geometryUserPtr);
    for (unsigned i = 0; i < args->N; ++i) {
        if (args->valid[i] != -1) continue;
        const uint32_t triangle = RTCHitN_primID(args->hit, args->N, i);
        const float u = RTCHitN_u(args->hit, args->N, i), v = RTCHitN_v(args->hit, args->N, i);
        if (!data->scene->solid_at(data->mesh, triangle, u, v)) args->valid[i] = 0;
    }
}

}  // namespace

struct EmbreeCaster::Impl {
    RTCScene top = nullptr;
    std::vector<RTCScene> groups;
    std::vector<GeometryData> data;               // one per mesh; never reallocated after construction
    std::vector<uint32_t> top_mesh, top_instance; // geomID of the top scene → mesh, or instance
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
    unsigned attach_mesh(RTCScene target, const Scene& scene, uint32_t index);
    void attach_instance(const Instance& instance, RTCScene group, uint32_t index);
    Hit hit_of(unsigned geom, unsigned inst, unsigned prim, float u, float v, float t) const;
};

unsigned EmbreeCaster::Impl::attach_mesh(RTCScene target, const Scene& scene, uint32_t index) {
    const Mesh& mesh = scene.meshes()[index];
    RTCGeometry g = rtcNewGeometry(shared_device(), RTC_GEOMETRY_TYPE_TRIANGLE);
    if (!mesh.triangles.empty()) {
        // New buffers (not shared ones): Embree pads them for its 16-byte loads.
        void* v = rtcSetNewGeometryBuffer(g, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, sizeof(Vec3), mesh.vertices.size());
        void* t = rtcSetNewGeometryBuffer(g, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, sizeof(Vec3u), mesh.triangles.size());
        if (!v || !t) throw std::bad_alloc();
        std::memcpy(v, mesh.vertices.data(), mesh.vertices.size() * sizeof(Vec3));
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

void EmbreeCaster::Impl::attach_instance(const Instance& instance, RTCScene group, uint32_t index) {
    RTCGeometry g = rtcNewGeometry(shared_device(), RTC_GEOMETRY_TYPE_INSTANCE);
    rtcSetGeometryInstancedScene(g, group);
    rtcSetGeometryTimeStepCount(g, 1);
    float m[12];  // column-major 3×4
    for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 4; ++c) m[3 * c + r] = float(instance.to_world.m[r][c]);
    rtcSetGeometryTransform(g, 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, m);
    rtcSetGeometryMask(g, 0xffffffffu);
    rtcCommitGeometry(g);
    const unsigned id = rtcAttachGeometry(top, g);
    rtcReleaseGeometry(g);
    top_mesh.resize(id + 1, kNoHit), top_instance.resize(id + 1, kNoHit);
    top_instance[id] = index;
}

Hit EmbreeCaster::Impl::hit_of(unsigned geom, unsigned inst, unsigned prim, float u, float v, float t) const {
    Hit hit;
    if (geom == RTC_INVALID_GEOMETRY_ID) return hit;
    hit.t = t, hit.u = u, hit.v = v, hit.triangle = prim;
    if (inst == RTC_INVALID_GEOMETRY_ID) {
        hit.mesh = top_mesh[geom];
    } else {
        hit.instance = top_instance[inst];
        hit.mesh = instance_mesh[hit.instance][geom];
    }
    return hit;
}

EmbreeCaster::EmbreeCaster(std::shared_ptr<const Scene> scene, EmbreeOptions options)
    : scene_(std::move(scene)), impl_(std::make_unique<Impl>()) {
    Impl& impl = *impl_;
    const auto& meshes = scene_->meshes();
    for (uint32_t i = 0; i < meshes.size(); ++i) impl.data.push_back({scene_.get(), i});
    impl.top = impl.new_scene(options.robust);
    for (uint32_t i = 0; i < meshes.size(); ++i) {
        if (!meshes[i].in_world || meshes[i].triangles.empty()) continue;
        const unsigned id = impl.attach_mesh(impl.top, *scene_, i);
        impl.top_mesh.resize(id + 1, kNoHit), impl.top_instance.resize(id + 1, kNoHit);
        impl.top_mesh[id] = i;
    }
    // One Embree scene per distinct list of meshes, shared by its instances.
    std::map<std::vector<int>, size_t> group_of;
    const auto& instances = scene_->description().instances;
    for (uint32_t i = 0; i < instances.size(); ++i) {
        auto [found, is_new] = group_of.try_emplace(instances[i].meshes, impl.groups.size());
        if (is_new) {
            impl.groups.push_back(impl.new_scene(options.robust));
            impl.group_mesh.emplace_back();
            for (int mesh : instances[i].meshes) {
                if (meshes[size_t(mesh)].triangles.empty()) continue;
                const unsigned id = impl.attach_mesh(impl.groups.back(), *scene_, uint32_t(mesh));
                impl.group_mesh.back().resize(id + 1, kNoHit);
                impl.group_mesh.back()[id] = uint32_t(mesh);
            }
            rtcCommitScene(impl.groups.back());
        }
        impl.attach_instance(instances[i], impl.groups[found->second], i);
        impl.instance_mesh.push_back(impl.group_mesh[found->second]);
    }
    rtcCommitScene(impl.top);
    const RTCError error = rtcGetDeviceError(shared_device());
    if (error == RTC_ERROR_OUT_OF_MEMORY) throw std::bad_alloc();
    if (error != RTC_ERROR_NONE) throw std::runtime_error("Embree could not build the scene: error " + std::to_string(error));
}

EmbreeCaster::~EmbreeCaster() = default;

std::string EmbreeCaster::version() {
    const auto number = [](RTCDeviceProperty p) { return std::to_string(rtcGetDeviceProperty(shared_device(), p)); };
    return number(RTC_DEVICE_PROPERTY_VERSION_MAJOR) + "." + number(RTC_DEVICE_PROPERTY_VERSION_MINOR) + "." +
           number(RTC_DEVICE_PROPERTY_VERSION_PATCH);
}

void EmbreeCaster::intersect(std::span<const Ray> rays, std::span<Hit> hits) const {
    rtc::Query query(Coherence::kIncoherent);
    for (size_t first = 0; first < rays.size(); first += 16) {
        const size_t n = std::min<size_t>(16, rays.size() - first);
        alignas(64) RTCRayHit16 packet;
        alignas(64) int valid[16];
        for (size_t i = 0; i < 16; ++i) {
            const Ray& r = rays[first + std::min(i, n - 1)];
            valid[i] = i < n && r.t_max > r.t_min ? -1 : 0;  // an empty interval holds no hit
            packet.ray.org_x[i] = r.o.x, packet.ray.org_y[i] = r.o.y, packet.ray.org_z[i] = r.o.z;
            packet.ray.dir_x[i] = r.d.x, packet.ray.dir_y[i] = r.d.y, packet.ray.dir_z[i] = r.d.z;
            packet.ray.tnear[i] = r.t_min, packet.ray.tfar[i] = r.t_max;
            packet.ray.time[i] = 0, packet.ray.mask[i] = ~0u, packet.ray.flags[i] = 0, packet.ray.id[i] = 0;
            packet.hit.geomID[i] = packet.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
        }
        query.intersect16(valid, impl_->top, packet);
        for (size_t i = 0; i < n; ++i)
            hits[first + i] = !valid[i] ? Hit{}
                                        : impl_->hit_of(packet.hit.geomID[i], packet.hit.instID[0][i],
                                                        packet.hit.primID[i], packet.hit.u[i], packet.hit.v[i],
                                                        packet.ray.tfar[i]);
    }
}

uint16_t EmbreeCaster::occluded16(uint16_t mask, RayPacket16& rays, Coherence coherence) const {
    rtc::Query query(coherence);
    alignas(64) RTCRay16 packet;
    alignas(64) int valid[16];
    constexpr size_t kRow = sizeof(float) * 16;
    std::memcpy(packet.org_x, rays.ox, kRow), std::memcpy(packet.org_y, rays.oy, kRow);
    std::memcpy(packet.org_z, rays.oz, kRow), std::memcpy(packet.tnear, rays.t_min, kRow);
    std::memcpy(packet.dir_x, rays.dx, kRow), std::memcpy(packet.dir_y, rays.dy, kRow);
    std::memcpy(packet.dir_z, rays.dz, kRow), std::memcpy(packet.tfar, rays.t_max, kRow);
    std::memset(packet.time, 0, kRow), std::memset(packet.flags, 0, kRow);
    std::memset(packet.mask, 0xff, kRow), std::memset(packet.id, 0, kRow);
    uint16_t active = 0;
    for (int i = 0; i < 16; ++i) {
        // An empty interval cannot be occluded; Embree would report its negative tfar as a hit.
        const bool is_active = (mask >> i & 1) && rays.t_max[i] > rays.t_min[i];
        valid[i] = is_active ? -1 : 0;
        active |= uint16_t(uint16_t(is_active) << i);
    }
    query.occluded16(valid, impl_->top, packet);
    uint16_t occluded = 0;
    for (int i = 0; i < 16; ++i) occluded |= uint16_t(uint16_t(packet.tfar[i] < 0) << i);
    return occluded & active;
}

void EmbreeCaster::occluded(std::span<const Ray> rays, std::span<uint8_t> occluded) const {
    for (size_t first = 0; first < rays.size(); first += 16) {
        const size_t n = std::min<size_t>(16, rays.size() - first);
        RayPacket16 packet;
        for (size_t i = 0; i < 16; ++i) {
            const Ray& r = rays[first + std::min(i, n - 1)];
            packet.ox[i] = r.o.x, packet.oy[i] = r.o.y, packet.oz[i] = r.o.z;
            packet.dx[i] = r.d.x, packet.dy[i] = r.d.y, packet.dz[i] = r.d.z;
            packet.t_min[i] = r.t_min, packet.t_max[i] = r.t_max;
        }
        const uint16_t bits = occluded16(uint16_t(n == 16 ? 0xffff : (1 << n) - 1), packet, Coherence::kIncoherent);
        for (size_t i = 0; i < n; ++i) occluded[first + i] = bits >> i & 1;
    }
}

namespace {

/// Copies ray i into lane `lane` of an Embree packet.
template <class Packet>
void put(Packet& p, int lane, const Ray& r) {
    p.org_x[lane] = r.o.x, p.org_y[lane] = r.o.y, p.org_z[lane] = r.o.z;
    p.dir_x[lane] = r.d.x, p.dir_y[lane] = r.d.y, p.dir_z[lane] = r.d.z;
    p.tnear[lane] = r.t_min, p.tfar[lane] = r.t_max;
    p.time[lane] = 0, p.mask[lane] = ~0u, p.flags[lane] = 0, p.id[lane] = 0;
}

template <class Packet, int kWidth, class Trace>
void bare_packets(std::span<const Ray> rays, std::span<uint8_t> out, Trace trace) {
    for (size_t first = 0; first < rays.size(); first += kWidth) {
        alignas(64) Packet packet;
        alignas(64) int valid[kWidth];
        const size_t n = std::min<size_t>(kWidth, rays.size() - first);
        for (size_t i = 0; i < kWidth; ++i) {
            valid[i] = i < n ? -1 : 0;
            put(packet, int(i), rays[first + std::min(i, n - 1)]);
        }
        trace(valid, packet);
        for (size_t i = 0; i < n; ++i) out[first + i] = packet.tfar[i] < 0;
    }
}

}  // namespace

void EmbreeCaster::bare_occluded(std::span<const Ray> rays, std::span<uint8_t> out, int width) const {
    rtc::Query query(Coherence::kIncoherent);
    const RTCScene top = impl_->top;
    if (width == 1) {
        for (size_t i = 0; i < rays.size(); ++i) {
            const Ray& r = rays[i];
            RTCRay ray{r.o.x, r.o.y, r.o.z, r.t_min, r.d.x, r.d.y, r.d.z, 0, r.t_max, ~0u, 0, 0};
            query.occluded1(top, ray);
            out[i] = ray.tfar < 0;
        }
    } else if (width == 4) {
        bare_packets<RTCRay4, 4>(rays, out, [&](const int* v, RTCRay4& p) { query.occluded4(v, top, p); });
    } else if (width == 8) {
        bare_packets<RTCRay8, 8>(rays, out, [&](const int* v, RTCRay8& p) { query.occluded8(v, top, p); });
    } else if (width == 16) {
        bare_packets<RTCRay16, 16>(rays, out, [&](const int* v, RTCRay16& p) { query.occluded16(v, top, p); });
    } else {
        throw std::invalid_argument("width must be 1, 4, 8 or 16, got " + std::to_string(width));
    }
}

}  // namespace viscache

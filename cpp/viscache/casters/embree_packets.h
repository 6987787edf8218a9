#pragma once
// Fills Embree's ray packets, traces them and reads the answers. Part of embree_caster.cpp.
#include <algorithm>
#include <cstring>
#include <stdexcept>
#include <string>

#include "viscache/casters/embree.h"
#include "viscache/casters/ray_arrays.h"
#include "viscache/casters/ray_batch.h"

namespace viscache::rtc {

inline void trace(Query& query, RTCScene scene, const int* valid, RTCRay4& rays) {
    query.occluded4(valid, scene, rays);
}
inline void trace(Query& query, RTCScene scene, const int* valid, RTCRay8& rays) {
    query.occluded8(valid, scene, rays);
}
inline void trace(Query& query, RTCScene scene, const int* valid, RTCRay16& rays) {
    query.occluded16(valid, scene, rays);
}

inline void intersect(Query& query, RTCScene scene, const int* valid, RTCRayHit8& rays) {
    query.intersect8(valid, scene, rays);
}
inline void intersect(Query& query, RTCScene scene, const int* valid, RTCRayHit16& rays) {
    query.intersect16(valid, scene, rays);
}

/// Sets the fields that are the same for all rays.
template <class Packet>
void set_common(Packet& packet) {
    std::memset(packet.time, 0, sizeof packet.time);
    std::memset(packet.flags, 0, sizeof packet.flags);
    std::memset(packet.mask, 0xff, sizeof packet.mask);
    std::memset(packet.id, 0, sizeof packet.id);
}

/// Nearest hits in packets of kWidth consecutive rays. `hit_of` converts (geomID, instID, primID, u, v, t) to
/// a Hit.
template <class Packet, int kWidth, class HitOf>
void nearest_packets(Query& query, RTCScene scene, std::span<const Ray> rays, std::span<Hit> hits,
                     HitOf hit_of) {
    alignas(64) Packet packet;
    alignas(64) int valid[kWidth];
    // Once: Embree does not change these fields
    set_common(packet.ray);
    for (size_t first = 0; first < rays.size(); first += kWidth) {
        const size_t n = std::min<size_t>(kWidth, rays.size() - first);
        for (size_t i = 0; i < kWidth; ++i) {
            // Lanes past the end repeat the last ray, so that all numbers are valid
            const Ray& r = rays[first + std::min(i, n - 1)];
            valid[i] = i < n && r.t_max > r.t_min ? -1 : 0;  // an empty interval contains no hit
            packet.ray.org_x[i] = r.o.x;
            packet.ray.org_y[i] = r.o.y;
            packet.ray.org_z[i] = r.o.z;
            packet.ray.dir_x[i] = r.d.x;
            packet.ray.dir_y[i] = r.d.y;
            packet.ray.dir_z[i] = r.d.z;
            packet.ray.tnear[i] = r.t_min;
            packet.ray.tfar[i] = r.t_max;
            // Embree writes where it hits; other lanes keep this
            packet.hit.geomID[i] = packet.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
        }
        intersect(query, scene, valid, packet);
        for (size_t i = 0; i < n; ++i)
            hits[first + i] =
                valid[i] ? hit_of(packet.hit.geomID[i], packet.hit.instID[0][i], packet.hit.primID[i],
                                  packet.hit.u[i], packet.hit.v[i], packet.ray.tfar[i])
                         : Hit{};
    }
}

/// Copies the lanes of a packet from `first` on.
template <int kWidth, class Packet>
void fill(Packet& packet, const RayPacket16& rays, size_t first) {
    constexpr size_t kRow = sizeof(float) * kWidth;
    // Both packets store arrays by component; they differ in their fields between
    std::memcpy(packet.org_x, rays.ox + first, kRow);
    std::memcpy(packet.org_y, rays.oy + first, kRow);
    std::memcpy(packet.org_z, rays.oz + first, kRow);
    std::memcpy(packet.tnear, rays.t_min + first, kRow);
    std::memcpy(packet.dir_x, rays.dx + first, kRow);
    std::memcpy(packet.dir_y, rays.dy + first, kRow);
    std::memcpy(packet.dir_z, rays.dz + first, kRow);
    std::memcpy(packet.tfar, rays.t_max + first, kRow);
}

/// Any hit for lanes [first, first + width of Packet) of sixteen rays.
template <class Packet, int kWidth>
uint32_t occluded_lanes(Query& query, RTCScene scene, uint32_t mask, const RayPacket16& rays, int first) {
    alignas(64) Packet packet;
    alignas(64) int valid[kWidth];
    fill<kWidth>(packet, rays, size_t(first));
    set_common(packet);
    for (int i = 0; i < kWidth; ++i) {
        // An empty interval cannot be occluded; Embree would report its negative tfar as a hit.
        const bool active = (mask >> i & 1) && packet.tfar[i] > packet.tnear[i];
        valid[i] = active ? -1 : 0;
        packet.tfar[i] = active ? packet.tfar[i] : kInfinity;
    }
    trace(query, scene, valid, packet);
    uint32_t occluded = 0;
    for (int i = 0; i < kWidth; ++i) occluded |= uint32_t(valid[i] && packet.tfar[i] < 0) << i;
    return occluded;
}

/// Any hit of checked rays in lanes. Stores the answer of ray i in blocked[i], up to a whole packet.
template <class Packet, int kWidth>
void occluded_batch(Query& query, RTCScene scene, const RayBatch& batch, uint8_t* blocked) {
    static_assert(16 % kWidth == 0);
    alignas(64) Packet packet;
    set_common(packet);
    for (size_t at = 0; at < batch.size(); at += kWidth) {
        const RayPacket16& rays = batch.lanes().packet[at / 16];
        const size_t lane = at % 16;
        const int32_t* asked = batch.lanes().asked[at / 16] + lane;
        fill<kWidth>(packet, rays, lane);
        trace(query, scene, asked, packet);
        // Where Embree splits wide packets, it also traces inactive lanes
        for (size_t i = 0; i < kWidth; ++i) blocked[at + i] = uint8_t(asked[i] & (packet.tfar[i] < 0));
    }
}

/// A plain loop: any hit in packets of kWidth consecutive rays, filled directly from the arrays.
template <class Packet, int kWidth>
void occluded_packets(Query& query, RTCScene scene, const RayArrays& rays, size_t first, size_t count,
                      uint8_t* occluded) {
    alignas(64) Packet packet;
    alignas(64) int valid[kWidth];
    set_common(packet);
    for (size_t at = first; at < first + count; at += kWidth) {
        const size_t n = std::min<size_t>(kWidth, first + count - at);
        for (size_t i = 0; i < kWidth; ++i) {
            const size_t k = at + std::min(i, n - 1);
            const Vec3 o = rays.origin[k], d = rays.direction[k];
            const float t = rays.t_max[k * rays.t_stride];
            const bool active = i < n && t > 0 && !(d == Vec3{});  // a ray with zero direction hits nothing
            valid[i] = active ? -1 : 0;
            packet.org_x[i] = o.x;
            packet.org_y[i] = o.y;
            packet.org_z[i] = o.z;
            packet.tnear[i] = 0;
            packet.dir_x[i] = d.x;
            packet.dir_y[i] = d.y;
            packet.dir_z[i] = d.z;
            packet.tfar[i] = active ? t : kInfinity;
        }
        trace(query, scene, valid, packet);
        for (size_t i = 0; i < n; ++i) occluded[at + i] = valid[i] && packet.tfar[i] < 0;
    }
}

inline void occluded_singly(Query& query, RTCScene scene, const RayArrays& rays, size_t first, size_t count,
                            uint8_t* occluded) {
    for (size_t k = first; k < first + count; ++k) {
        const Vec3 o = rays.origin[k], d = rays.direction[k];
        const float t = rays.t_max[k * rays.t_stride];
        occluded[k] = 0;
        if (!(t > 0) || d == Vec3{}) continue;
        RTCRay ray{o.x, o.y, o.z, 0, d.x, d.y, d.z, 0, t, ~0u, 0, 0};
        query.occluded1(scene, ray);
        occluded[k] = ray.tfar < 0;
    }
}

inline void occluded_by_plan(RTCScene scene, const RayArrays& rays, size_t first, size_t count,
                             uint8_t* occluded, const PacketPlan& plan) {
    Query query(plan.coherence);
    switch (plan.width) {
        case 1: return occluded_singly(query, scene, rays, first, count, occluded);
        case 4: return occluded_packets<RTCRay4, 4>(query, scene, rays, first, count, occluded);
        case 8: return occluded_packets<RTCRay8, 8>(query, scene, rays, first, count, occluded);
        case 16: return occluded_packets<RTCRay16, 16>(query, scene, rays, first, count, occluded);
        default:
            throw std::invalid_argument("width must be 1, 4, 8 or 16, got " + std::to_string(plan.width));
    }
}

/// Traces kWidth lanes along the axes on their sides; returns the blocked lanes. The packet already contains
/// the origins.
template <class Packet, int kWidth>
uint32_t blocked_lanes(Query& query, RTCScene scene, Packet& packet, const int* valid, float t_max) {
    for (int i = 0; i < kWidth; ++i) {
        packet.tnear[i] = 0;
        packet.tfar[i] = t_max;
    }
    trace(query, scene, valid, packet);
    uint32_t blocked = 0;
    for (int i = 0; i < kWidth; ++i) blocked |= uint32_t(packet.tfar[i] < 0) << i;
    return blocked;
}

template <class Packet, int kWidth>
void trace_along(Query& query, RTCScene scene, const PointLanes& p, Vec3 axis, float t_max,
                 uint16_t* blocked) {
    alignas(64) Packet packet;
    alignas(64) int valid[kWidth];
    constexpr size_t kRow = sizeof(float) * kWidth;
    set_common(packet);
    for (size_t at = 0; at < p.packets * 16; at += kWidth) {
        const uint32_t asked = uint32_t(p.asked[at / 16]) >> (at % 16);
        std::memcpy(packet.org_x, p.x + at, kRow);
        std::memcpy(packet.org_y, p.y + at, kRow);
        std::memcpy(packet.org_z, p.z + at, kRow);
        for (int i = 0; i < kWidth; ++i) {
            const size_t k = at + size_t(i);
            // The end of the axis that lies above the surface
            const float side = axis.x * p.nx[k] + axis.y * p.ny[k] + axis.z * p.nz[k] >= 0 ? 1.f : -1.f;
            packet.dir_x[i] = side * axis.x;
            packet.dir_y[i] = side * axis.y;
            packet.dir_z[i] = side * axis.z;
            valid[i] = -int(asked >> i & 1);
        }
        const uint32_t found =
            blocked_lanes<Packet, kWidth>(query, scene, packet, valid, t_max) & asked & ((1u << kWidth) - 1);
        // Packets of 8 share a word of 16: the first one clears it
        if (at % 16 == 0) blocked[at / 16] = 0;
        blocked[at / 16] = uint16_t(blocked[at / 16] | found << (at % 16));
    }
}

template <class Packet, int kWidth>
void trace_from(Query& query, RTCScene scene, Vec3 o, Vec3 n, const AxisLanes& axes, float t_max,
                Word* blocked) {
    alignas(64) Packet packet;
    alignas(64) int valid[kWidth];
    set_common(packet);
    for (int i = 0; i < kWidth; ++i) {
        packet.org_x[i] = o.x;
        packet.org_y[i] = o.y;
        packet.org_z[i] = o.z;
    }
    for (size_t at = 0; at < axes.count; at += kWidth) {
        for (int i = 0; i < kWidth; ++i) {
            const size_t k = at + size_t(i);
            const float x = axes.x[k], y = axes.y[k], z = axes.z[k];
            const float side = x * n.x + y * n.y + z * n.z >= 0 ? 1.f : -1.f;
            packet.dir_x[i] = side * x;
            packet.dir_y[i] = side * y;
            packet.dir_z[i] = side * z;
            valid[i] = k < axes.count ? -1 : 0;
        }
        // Directions past the end have no bit
        const size_t left = std::min<size_t>(kWidth, axes.count - at);
        const uint32_t found =
            blocked_lanes<Packet, kWidth>(query, scene, packet, valid, t_max) & ((1u << left) - 1);
        if (at % kWordBits == 0) blocked[at / kWordBits] = 0;
        blocked[at / kWordBits] |= Word{found} << (at % kWordBits);
    }
}

/// Plans for shared directions.
inline bool is_wide(const PacketPlan& plan) {
    if (plan.width != 8 && plan.width != 16)
        throw std::invalid_argument("width must be 8 or 16, got " + std::to_string(plan.width));
    return plan.width == 16;
}

}  // namespace viscache::rtc

#pragma once
// The ray that answers one connection. The exact oracle and all caches share this definition, because a
// cache with sufficiently small cells must give the exact image bit for bit.
//
// Segments (to points and surfaces) start at the spawned origin with d = end − origin and t in [0, 1 −
// min(1, end_offset / |d|)]. Directional rays extend to t_max. The 16-wide forms compute the same
// floats in the same order as the scalar ones.
#include "viscache/visibility/oracle.h"
#include "viscache/visibility/query.h"
#include "viscache/visibility/ray_caster.h"

namespace viscache {

inline bool is_direction(Semantic s) { return s == Semantic::kDirection || s == Semantic::kSolidAngle; }

/// Ray of eye point `eye` towards column k of a light group.
inline Ray shadow_ray(const EyeBlock& eyes, uint32_t eye, const FarEnds& lights, size_t k) {
    const Vec3 end{lights.tx[k], lights.ty[k], lights.tz[k]};
    if (is_direction(lights.semantic)) return {eyes.origin[eye], 0, end, lights.t_max};
    return segment_to_point(eyes.origin[eye], end);
}

/// Ray of one connection.
inline Ray shadow_ray(const EyeBlock& eyes, const ShadowQuery& q) {
    if (is_direction(q.semantic)) return {eyes.origin[q.eye], 0, q.far, q.t_max};
    return segment_to_point(eyes.origin[q.eye], q.ray_end);
}

/// True if rays may start, end or point there. Connections with other ends are never traced; they count as
/// bypassed.
inline bool is_traceable(Vec3 p) { return is_finite(p) && max_abs(p) <= kMaxCoordinate; }

/// Fills the unused lanes of a partial packet with copies of its first lane, because they must be finite.
inline void pad_lanes(RayPacket16& packet, int used) {
    for (int i = used; i < 16; ++i) packet.set(size_t(i), packet.ray(0));
}

/// Converts 16 end points, stored in (dx, dy, dz), to the rays that `segment_to_point` gives.
inline void aim_at_points16(RayPacket16& packet) {
    for (int i = 0; i < 16; ++i) {
        const auto larger = [](float a, float b) { return a > b ? a : b; };
        const float x = larger(std::fabs(packet.ox[i]), std::fabs(packet.dx[i])),
                    y = larger(std::fabs(packet.oy[i]), std::fabs(packet.dy[i])),
                    z = larger(std::fabs(packet.oz[i]), std::fabs(packet.dz[i]));
        const float size = larger(larger(x, y), z);
        const float dx = packet.dx[i] - packet.ox[i];
        const float dy = packet.dy[i] - packet.oy[i];
        const float dz = packet.dz[i] - packet.oz[i];
        const float relative = kOffsetUlps * kUlp * size / std::sqrt(dx * dx + dy * dy + dz * dz);
        packet.aim(size_t(i), {dx, dy, dz});
        packet.t_min[i] = 0;
        packet.t_max[i] = 1.f - (relative < 1.f ? relative : 1.f);
    }
}

/// Converts 16 directions in (dx, dy, dz) to rays of length t_max.
inline void aim_along16(RayPacket16& packet, float t_max) {
    for (int i = 0; i < 16; ++i) {
        packet.t_min[i] = 0;
        packet.t_max[i] = t_max;
    }
}

/// One of the two, by the semantic of the far ends.
inline void aim16(RayPacket16& packet, const FarEnds& lights) {
    if (is_direction(lights.semantic))
        aim_along16(packet, lights.t_max);
    else
        aim_at_points16(packet);
}

}  // namespace viscache

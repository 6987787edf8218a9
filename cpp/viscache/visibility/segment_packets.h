#pragma once
// Packets of 16 segments between two points.
#include "viscache/visibility/query.h"
#include "viscache/visibility/ray_caster.h"

namespace viscache {

/// Converts 16 origins and 16 end points, stored in (dx, dy, dz), to the rays that `segment_between` gives.
inline void segments16(RayPacket16& packet) {
    const auto size16 = [](float x, float y, float z) {
        x = std::fabs(x);
        y = std::fabs(y);
        z = std::fabs(z);
        x = x > y ? x : y;
        return x > z ? x : z;
    };
    for (int i = 0; i < 16; ++i) {
        const float here = size16(packet.ox[i], packet.oy[i], packet.oz[i]);
        const float there = size16(packet.dx[i], packet.dy[i], packet.dz[i]);
        const float size = here > there ? here : there;
        const float dx = packet.dx[i] - packet.ox[i];
        const float dy = packet.dy[i] - packet.oy[i];
        const float dz = packet.dz[i] - packet.oz[i];
        const float distance = std::sqrt(dx * dx + dy * dy + dz * dz);
        const float relative = kSegmentUlps * kUlp * size / distance;
        // NaN, where both points are the origin, is not below 1 either
        const float e = relative < 1.f ? relative : 1.f;
        packet.dx[i] = dx;
        packet.dy[i] = dy;
        packet.dz[i] = dz;
        packet.t_min[i] = e;
        packet.t_max[i] = 1 - e;
    }
}

/// Occluded lanes of segments, out of `mask`. Incoherent: where a segment lies along a face of one of
/// Embree's boxes, its answer in a coherent packet depends on the other rays of the packet.
inline uint16_t occluded_segments16(const RayCaster& caster, uint16_t mask, RayPacket16& packet) {
    segments16(packet);
    return caster.occluded16(mask, packet, Coherence::kIncoherent);
}

}  // namespace viscache

#pragma once
// Packets of 16 segments between two points.
#include "viscache/visibility/query.h"
#include "viscache/visibility/ray_caster.h"

namespace viscache {

/// Segments that advance less than this along an axis, in units of the largest coordinate of their ends, may
/// lie along a face of one of Embree's boxes. There, answers of coherent packets depend on the other rays.
/// Ten times the largest such advance found in 7.7 million segments in each of ten scenes (2e-7).
constexpr float kFlatSegment = 2e-6f;

/// Converts 16 origins and 16 end points, stored in (dx, dy, dz), to the rays that `segment_between` gives.
/// Returns the lanes that are flat.
inline uint32_t segments16(RayPacket16& packet) {
    int32_t is_flat[16];
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
        const float ax = std::fabs(dx), ay = std::fabs(dy), az = std::fabs(dz);
        float advance = ax < ay ? ax : ay;
        advance = advance < az ? advance : az;
        is_flat[i] = advance <= kFlatSegment * size;
    }
    uint32_t flat = 0;
    for (int i = 0; i < 16; ++i) flat |= uint32_t(is_flat[i]) << i;
    return flat;
}

/// Traces packets of segments with the answers of single rays.
class SegmentPackets {
public:
    explicit SegmentPackets(const RayCaster& caster) : caster_(caster), flag_(caster.flag_of_segments()) {}

    /// Occluded lanes, out of `mask`, of 16 origins and 16 end points, which are overwritten.
    uint16_t occluded(uint16_t mask, RayPacket16& packet) const {
        const uint32_t flat = flag_ == Coherence::kCoherent ? segments16(packet) & mask : 0;
        if (flag_ == Coherence::kIncoherent) segments16(packet);
        const uint32_t rest = mask & ~flat;
        uint32_t found = 0;
        if (flat) {
            RayPacket16 copy = packet;
            found = caster_.occluded16(uint16_t(flat), copy, Coherence::kIncoherent);
        }
        if (rest) found |= caster_.occluded16(uint16_t(rest), packet, flag_);
        return uint16_t(found);
    }

private:
    const RayCaster& caster_;
    Coherence flag_;
};

}  // namespace viscache

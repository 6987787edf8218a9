#include "viscache/visibility/block_tracer.h"

#include <algorithm>

namespace viscache {

namespace {
// Shares of rays in the class of their predecessor. Fitted on five scenes with twenty sets of rays, judged on
// four others: docs/performance/rays.md.
constexpr double kImage = 0.95;          // from here on coherent packets: the rays of a camera
constexpr double kInOrder = 0.6;         // below, sorting saves more than it costs
constexpr size_t kMinSortedRays = 4096;  // smaller blocks gain nothing from sorting
}  // namespace

BlockTracer::BlockTracer(const EmbreeCaster& caster, const RayArrays& rays, uint8_t* occluded,
                         std::optional<RayWay> fixed)
    : caster_(caster), rays_(rays), occluded_(occluded), fixed_(fixed) {}

RayWay BlockTracer::way_of(size_t first, size_t count) {
    if (fixed_) return *fixed_;
    const double share = order_.share_in_order(rays_, first, count);
    if (share >= kImage) return RayWay::kCoherent;
    return share < kInOrder && count >= kMinSortedRays ? RayWay::kSorted : RayWay::kAsGiven;
}

bool BlockTracer::block(size_t first, size_t count) {
    const RayWay way = way_of(first, count);
    // Where AVX-512 traces 16 rays at once, incoherent packets of 16 are as fast as those of 8 once sorted,
    // and faster in cheap scenes
    const PacketPlan plan{caster_.native16() ? 16 : 8,
                          way == RayWay::kCoherent ? Coherence::kCoherent : Coherence::kIncoherent};
    std::span<const uint32_t> order;
    if (way == RayWay::kSorted) order = order_.sort(rays_, first, count);
    alignas(64) uint8_t blocked[RayBatch::kMost];
    for (size_t at = 0; at < count; at += RayBatch::kMost) {
        const size_t n = std::min(RayBatch::kMost, count - at);
        if (order.empty()) {
            if (!batch_.take(rays_, first + at, n)) return false;
            caster_.occluded(batch_, blocked, plan);
            std::copy_n(blocked, n, occluded_ + first + at);
        } else {
            if (!batch_.take(rays_, order.subspan(at, n))) return false;
            caster_.occluded(batch_, blocked, plan);
            for (size_t i = 0; i < n; ++i) occluded_[order[at + i]] = blocked[i];
        }
    }
    return true;
}

}  // namespace viscache

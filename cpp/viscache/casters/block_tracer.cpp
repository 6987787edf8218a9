#include "viscache/casters/block_tracer.h"

#include <algorithm>

#include "viscache/casters/ray_batch.h"
#include "viscache/casters/ray_order.h"

namespace viscache {

namespace {

// Shares of rays in the class of their predecessor. Fitted on six scenes with 19 sets of rays, judged on
// three others: docs/performance/rays.md.
constexpr double kImage = 0.95;          // from here on coherent packets: the rays of a camera
constexpr double kInOrder = 0.6;         // below, sorting saves more than it costs
constexpr size_t kMinSortedRays = 8192;  // smaller blocks gain nothing from sorting

// Rays of larger blocks lie closer together once sorted: 131,072 instead of 41,667 save 8 % of random
// segments
constexpr size_t kMostRays = 1 << 18;
constexpr size_t kLeastRays = 1 << 13;
constexpr size_t kPiece = 1 << 12;  // rays that a thread takes at a time

/// Rays that are traced in one way.
struct Block {
    size_t first = 0, count = 0;
    RayWay way = RayWay::kAsGiven;
    RayOrder order;
    std::span<const uint32_t> sorted;

    void prepare(const RayArrays& rays, std::optional<RayWay> fixed) {
        way = fixed ? *fixed : way_of(order.share_in_order(rays, first, count));
        sorted = {};
        if (way == RayWay::kSorted) sorted = order.sort(rays, first, count);
    }
    RayWay way_of(double share) const {
        if (share >= kImage) return RayWay::kCoherent;
        return share < kInOrder && count >= kMinSortedRays ? RayWay::kSorted : RayWay::kAsGiven;
    }
};

/// Traces the rays [first, last) of a block's order. Stops at a batch with a ray that must not be traced.
bool trace_piece(const EmbreeCaster& caster, const RayArrays& rays, const Block& block, size_t first,
                 size_t last, RayBatch& batch, uint8_t* occluded) {
    // Where AVX-512 traces 16 rays at once, incoherent packets of 16 are as fast as those of 8 once sorted,
    // and faster in cheap scenes
    const PacketPlan plan{
        caster.native16() ? 16 : 8,
        block.way == RayWay::kCoherent ? Coherence::kCoherent : Coherence::kIncoherent,
    };
    alignas(64) uint8_t blocked[RayBatch::kMost];
    for (size_t at = first; at < last; at += RayBatch::kMost) {
        const size_t n = std::min(RayBatch::kMost, last - at);
        const bool usable = block.sorted.empty() ? batch.take(rays, block.first + at, n)
                                                 : batch.take(rays, block.sorted.subspan(at, n));
        if (!usable) return false;
        caster.occluded(batch, blocked, plan);
        if (block.sorted.empty())
            std::copy_n(blocked, n, occluded + block.first + at);
        else
            for (size_t i = 0; i < n; ++i) occluded[block.sorted[at + i]] = blocked[i];
    }
    return true;
}

}  // namespace

bool trace_any_hits(const EmbreeCaster& caster, const RayArrays& rays, size_t count, uint8_t* occluded,
                    int threads, Control& control, std::optional<RayWay> fixed) {
    threads = resolve_threads(threads);
    const size_t most = std::clamp(count / size_t(threads), kLeastRays, kMostRays);
    const size_t pieces = (most + kPiece - 1) / kPiece;
    std::vector<Block> blocks(std::min(size_t(threads), (count + most - 1) / most));
    std::vector<RayBatch> batches(blocks.empty() ? 0 : size_t(threads));
    std::atomic<bool> usable{true};
    for (size_t next = 0; next < count && usable;) {
        // One block for each thread. Then all threads trace the pieces of all blocks, so that they end
        // together
        size_t taken = 0;
        for (; taken < blocks.size() && next < count; ++taken) {
            blocks[taken].first = next;
            blocks[taken].count = std::min(most, count - next);
            next += blocks[taken].count;
        }
        parallel_for(taken, threads, [&](size_t b, int) { blocks[b].prepare(rays, fixed); });
        parallel_for(taken * pieces, threads, [&](size_t p, int worker) {
            control.check();
            const Block& block = blocks[p / pieces];
            const size_t first = p % pieces * kPiece, last = std::min(block.count, first + kPiece);
            if (!usable || first >= last) return;
            if (!trace_piece(caster, rays, block, first, last, batches[size_t(worker)], occluded))
                usable = false;
        });
    }
    return usable;
}

}  // namespace viscache

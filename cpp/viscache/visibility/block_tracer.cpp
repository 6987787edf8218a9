#include "viscache/visibility/block_tracer.h"

namespace viscache {

namespace {
constexpr size_t kPiece = 1024;         // rays by one flag
constexpr size_t kTrialPeriod = 64;     // pieces between trials: images change from top to bottom
constexpr size_t kWorthSorting = 4096;  // rays; fewer have no neighbours to find
constexpr double kInOrder = 0.3;        // share of rays like the one before
constexpr double kCheap = 60e-9;        // seconds a ray; sorting takes about 15 and gains a fifth
}  // namespace

BlockTracer::BlockTracer(const EmbreeCaster& caster, const RayArrays& rays, uint8_t* occluded)
    : caster_(caster), rays_(rays), occluded_(occluded), flag_(std::nullopt, kTrialPeriod) {}

void BlockTracer::block(size_t first, size_t count) {
    const double before = thread_cpu_seconds();
    if (sorting_ == Sorting::kOnTrial || sorting_ == Sorting::kPays)
        trace_sorted(first, count);
    else
        trace_as_given(first, count);
    if (count >= kWorthSorting) choose(first, count, thread_cpu_seconds() - before);
}

/// Decides how later blocks are traced by what this one took.
void BlockTracer::choose(size_t first, size_t count, double seconds) {
    const double per_ray = seconds / double(count);
    if (sorting_ == Sorting::kOnTrial) {
        sorting_ = per_ray < seconds_per_ray_ ? Sorting::kPays : Sorting::kNot;
    } else if (sorting_ == Sorting::kUnknown && per_ray >= kCheap) {
        seconds_per_ray_ = per_ray;
        order_.classify(rays_, first, count);
        if (order_.share_in_order() < kInOrder) sorting_ = Sorting::kOnTrial;
    }
}

void BlockTracer::trace_as_given(size_t first, size_t count) {
    for (size_t at = 0; at < count; at += kPiece)
        flag_.piece([&](Coherence flag) {
            // Measured: incoherent packets of 8 are as fast as those of 16 or faster
            const PacketPlan plan{flag == Coherence::kCoherent && caster_.native16() ? 16 : 8, flag};
            const size_t n = std::min(kPiece, count - at);
            caster_.occluded(rays_, first + at, n, occluded_, plan);
            return n;
        });
}

void BlockTracer::trace_sorted(size_t first, size_t count) {
    order_.classify(rays_, first, count);
    caster_.occluded(rays_, order_.sort(), occluded_, {8, Coherence::kIncoherent});
}

}  // namespace viscache

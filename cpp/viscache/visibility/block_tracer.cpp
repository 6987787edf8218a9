#include "viscache/visibility/block_tracer.h"

namespace viscache {

namespace {
constexpr size_t kPiece = 1024;          // rays traced with one flag
constexpr size_t kTrialPeriod = 64;      // pieces between trials: images change from top to bottom
constexpr size_t kMinSortedRays = 4096;  // rays; smaller blocks gain nothing from sorting
constexpr double kInOrder = 0.3;         // fraction of rays in the same class as their predecessor
constexpr double kCheap = 60e-9;  // seconds per ray; sorting takes about 15 ns per ray and saves a fifth
}  // namespace

BlockTracer::BlockTracer(const EmbreeCaster& caster, const RayArrays& rays, uint8_t* occluded)
    : caster_(caster), rays_(rays), occluded_(occluded), flag_(std::nullopt, kTrialPeriod) {}

void BlockTracer::block(size_t first, size_t count) {
    const double before = thread_cpu_seconds();
    if (sorting_ == Sorting::kOnTrial || sorting_ == Sorting::kPays)
        trace_sorted(first, count);
    else
        trace_as_given(first, count);
    if (count >= kMinSortedRays) choose(first, count, thread_cpu_seconds() - before);
}

/// Decides how later blocks are traced, from the time that this block took.
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
            // Measured: incoherent packets of 8 are at least as fast as those of 16
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

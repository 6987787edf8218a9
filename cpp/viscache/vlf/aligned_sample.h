#pragma once
// Estimates the work of the aligned batch from a sample of the rays.
#include "viscache/vlf/aligned_batch.h"

namespace viscache {

/// Work of the batch per ray.
struct AlignedWork {
    double blocks = 0, nodes = 0, pairs = 0, tests = 0, wide = 0, exact = 0;  ///< as in AlignedCounts
    double free = 0;  ///< share of the rays that nothing blocks
    static AlignedWork of(const AlignedCounts& counts, uint64_t rays, uint64_t free);
};

/// Traces about one ray in 256, in passes of one axis for one run of neighbouring points. Runs and axes are
/// spread evenly. The result depends neither on `threads` nor on `isa`.
AlignedWork sampled_work(const AlignedBatch& batch, const AlignedInput& input, int threads, Control& control,
                         Isa isa = active_isa());

}  // namespace viscache

#pragma once
// Traces any-hit rays of a caller's arrays, block by block, in the fastest way. Affects speed only: in
// robust scenes every way gives the same answers.
#include <cstdint>

#include "viscache/visibility/coherence_trial.h"
#include "viscache/visibility/embree_caster.h"
#include "viscache/visibility/ray_order.h"

namespace viscache {

/// One object per thread and batch of similar rays. Rays in a coherent order, such as that of an image, are
/// traced as given, with the traversal flag that is fastest in trials. Other rays are sorted first, unless
/// they are cheap or sorting a block did not save time.
class BlockTracer {
public:
    /// The answer for ray k is stored in occluded[k].
    BlockTracer(const EmbreeCaster& caster, const RayArrays& rays, uint8_t* occluded);
    /// Traces rays [first, first + count).
    void block(size_t first, size_t count);

private:
    enum class Sorting { kUnknown, kOnTrial, kPays, kNot };
    void choose(size_t first, size_t count, double seconds);
    void trace_as_given(size_t first, size_t count);
    void trace_sorted(size_t first, size_t count);

    const EmbreeCaster& caster_;
    RayArrays rays_;
    uint8_t* occluded_;
    CoherenceTrial flag_;
    RayOrder order_;
    Sorting sorting_ = Sorting::kUnknown;
    double seconds_per_ray_ = 0;  ///< of the last block that was traced as given
};

}  // namespace viscache

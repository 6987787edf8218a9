#pragma once
// Batches of hemisphere directions. The loop is vectorised; the variant is chosen at run time.
#include <cstdint>

#include "viscache/math/frame.h"
#include "viscache/math/isa.h"

namespace viscache {

/// A randomised (0,2)-sequence mapped to the hemisphere around a frame's z axis.
struct HemisphereSequence {
    uint32_t scramble_x, scramble_y;  ///< scrambles of `sobol02`
    Frame3 frame;
    bool cosine = true;  ///< true: cosine-weighted; false: uniform
};

struct HemisphereBatch {
    static constexpr uint32_t kSize = 32, kLanes = 16;
    alignas(64) float x[kSize], y[kSize], z[kSize];
    alignas(64) float cosine[kSize];  ///< cosine to the frame's axis, >= 0
};

/// Points first … first + n − 1 of the sequence, n <= kSize; rounded up to whole vectors. All variants give
/// the same bits.
void hemisphere_batch(const HemisphereSequence& sequence, uint32_t first, uint32_t n, HemisphereBatch& out,
                      Isa isa = active_isa());

}  // namespace viscache

#pragma once
// Directions of a hemisphere by the batch: the loop runs in SIMD, the variant chosen at run time.
#include <cstdint>

#include "viscache/math/frame.h"
#include "viscache/math/isa.h"

namespace viscache {

/// A randomised (0,2)-sequence on the hemisphere around a frame's z axis.
struct HemisphereSequence {
    uint32_t scramble_x, scramble_y;  ///< of `sobol02`
    Frame3 frame;
    bool cosine = true;  ///< weighted by the cosine; false: uniform
};

struct HemisphereBatch {
    static constexpr uint32_t kSize = 32;
    alignas(64) float x[kSize], y[kSize], z[kSize];
    alignas(64) float cosine[kSize];  ///< to the axis, >= 0
};

/// Points first … first + kSize − 1 of the sequence; the same bits from every variant.
void hemisphere_batch(const HemisphereSequence& sequence, uint32_t first, HemisphereBatch& out,
                      Isa isa = active_isa());

}  // namespace viscache

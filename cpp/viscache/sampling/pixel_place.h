#pragma once
// Where the samples of a pixel lie: all methods look through the same places.
#include "viscache/sampling/low_discrepancy.h"
#include "viscache/sampling/rng.h"

namespace viscache {

/// Place of a sample in its pixel, in [0, 1)²: an Owen-scrambled (0, 2)-sequence of every pixel's own.
inline Vec2 pixel_place(uint64_t seed, uint64_t pixel, uint32_t sample) {
    Rng rng(seed, Purpose::kPixel, pixel, 0);
    const uint32_t scramble_x = rng.next_u32(), scramble_y = rng.next_u32();
    return sobol02(sample, scramble_x, scramble_y);
}

}  // namespace viscache

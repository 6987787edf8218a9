#pragma once
// Uniform directions by the batch: the loop runs in SIMD, the variant chosen at run time.
#include <cstddef>
#include <cstdint>

#include "viscache/math/isa.h"

namespace viscache {

/// Points first … first + n − 1 of the (0,2)-sequence with these scrambles (`sobol02`), spread evenly over
/// the sphere: the halves of the first coordinate become hemispheres. n is a multiple of 16; the same bits
/// from every variant.
void sphere_batch(uint32_t scramble_x, uint32_t scramble_y, uint32_t first, size_t n, float* x, float* y,
                  float* z, Isa isa = active_isa());

}  // namespace viscache

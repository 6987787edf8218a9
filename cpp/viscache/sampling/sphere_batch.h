#pragma once
// Batches of uniform directions. The loop is vectorised; the variant is chosen at run time.
#include <cstddef>
#include <cstdint>

#include "viscache/math/isa.h"

namespace viscache {

/// Points first … first + n − 1 of the (0,2)-sequence with these scrambles (`sobol02`), uniform on the
/// sphere. Each half of the first coordinate is mapped to one hemisphere. n is a multiple of 16. All
/// variants give the same bits.
void sphere_batch(uint32_t scramble_x, uint32_t scramble_y, uint32_t first, size_t n, float* x, float* y,
                  float* z, Isa isa = active_isa());

}  // namespace viscache

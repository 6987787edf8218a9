#pragma once
// Batches of the equal-area octahedral map. The loops are vectorised; the variant is chosen at run time.
#include <cstddef>

#include "viscache/math/isa.h"

namespace viscache {

constexpr size_t kEqualAreaLanes = 16;

/// `equal_area_to_direction` of n points (u, v), bit by bit. n is a multiple of kEqualAreaLanes; the arrays
/// do not overlap.
void equal_area_to_directions(const float* u, const float* v, size_t n, float* x, float* y, float* z,
                              Isa isa = active_isa());
/// `direction_to_equal_area` of n unit directions, likewise.
void directions_to_equal_area(const float* x, const float* y, const float* z, size_t n, float* u, float* v,
                              Isa isa = active_isa());

}  // namespace viscache

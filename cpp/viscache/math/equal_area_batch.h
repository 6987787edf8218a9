#pragma once
// Batches of the equal-area octahedral map. The loops are vectorised; the variant is chosen at run time.
#include <cstddef>
#include <span>

#include "viscache/math/isa.h"
#include "viscache/math/vec.h"

namespace viscache {

constexpr size_t kEqualAreaLanes = 16;

/// `equal_area_to_direction` of n points (u, v), bit by bit. n is a multiple of kEqualAreaLanes; the arrays
/// do not overlap.
void equal_area_to_directions(const float* u, const float* v, size_t n, float* x, float* y, float* z,
                              Isa isa = active_isa());
/// `direction_to_equal_area` of n unit directions, likewise.
void directions_to_equal_area(const float* x, const float* y, const float* z, size_t n, float* u, float* v,
                              Isa isa = active_isa());
/// The same for rows of any count.
void equal_area_to_directions(std::span<const Vec2> points, std::span<Vec3> directions);
void directions_to_equal_area(std::span<const Vec3> directions, std::span<Vec2> points);

}  // namespace viscache

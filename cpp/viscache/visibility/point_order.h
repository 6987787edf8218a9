#pragma once
// The eye points of a tile in the order of a spatial tree, and bit rows in that order.
#include <cstdint>
#include <span>
#include <vector>

#include "viscache/math/bits.h"
#include "viscache/math/vec.h"

namespace viscache {

/// Indices of the points in an order in which runs of 16, 32, 64, … points are compact. Points are split at
/// medians of the longest side of their bounding box; the left side has 16 · 2^k points. Equal coordinates
/// are ordered by index, so the order depends on nothing but the points.
std::vector<uint32_t> packet_order(std::span<const Vec3> points);

/// Row i of `to` is row order[i] of `from`.
void gather_rows(const BitMatrix& from, std::span<const uint32_t> order, BitMatrix& to);
/// Row order[i] of `to` is row i of `from`. `to` has the size of `from`.
void scatter_rows(const BitMatrix& from, std::span<const uint32_t> order, BitMatrix& to);

}  // namespace viscache

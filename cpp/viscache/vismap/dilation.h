#pragma once
// Dilation of maps. Dilated maps are only used for the density of guided sampling.
#include "viscache/vismap/record.h"

namespace viscache {

constexpr int kMostDilations = 3;
/// log2 of the cells along an edge of V^level, level 1 to dilations(m).
constexpr int dilated_log2(int m, int level) { return m - level + 1; }
constexpr size_t dilated_words(int m, int level) { return map_words(dilated_log2(m, level)); }

/// Dilates a map by one cell in all eight directions, in Z order. Across the border of the square,
/// neighbours are those on the sphere.
void grow(int map_log2, const Word* bits, Word* grown);
/// Sets the cells of which any of the four children is set; map_log2 is that of `bits`.
void any_of_four(int map_log2, const Word* bits, Word* coarse);

/// V^level, level = 1 to dilations(m): OR over blocks of 2^(level − 1) cells along an edge, then dilated. V
/// ⊆ V¹ ⊆ V² ⊆ V³ as sets of directions.
void dilate(int m, const Word* bits, int level, Word* dilated);

}  // namespace viscache

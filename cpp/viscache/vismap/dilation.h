#pragma once
// Maps grown over their neighbours: they shape the density of guided sampling, and nothing else.
#include "viscache/vismap/record.h"

namespace viscache {

constexpr int kMostDilations = 3;
/// log2 of the cells along an edge of V^level, level 1 to dilations(m).
constexpr int dilated_log2(int m, int level) { return m - level + 1; }
constexpr size_t dilated_words(int m, int level) { return map_words(dilated_log2(m, level)); }

/// Every set cell with its eight neighbours, in Z order; across the border of the square these are the ones
/// on the sphere.
void grow(int map_log2, const Word* bits, Word* grown);
/// Cells of which any of the four children is set; map_log2 is that of `bits`.
void any_of_four(int map_log2, const Word* bits, Word* coarse);

/// V^level, level = 1 to dilations(m): any on blocks of 2^(level − 1) cells along an edge, then grown.
/// V ⊆ V¹ ⊆ V² ⊆ V³ as sets of directions.
void dilate(int m, const Word* bits, int level, Word* dilated);

}  // namespace viscache

#pragma once
// Approximate visibility at a point, blended from nearby records: the interface between the cache and its
// users.
#include "viscache/math/bits.h"

namespace viscache {

constexpr int kMaxBlended = 8;  ///< maximum number of records blended at one point

/// The records used at one point and their weights: Ṽ = Σ β_i V_i. Maps are 2^m × 2^m cells of the
/// equal-area octahedral map along the Morton curve: cell z is bit z % 64 of word z / 64.
///
///      0  1 |  4  5        Morton curve: the bits of x and y alternate, x lowest. A word is a block
///      2  3 |  6  7        of 8 × 8 cells; the children of a quadtree node are four successive cells.
///     ------+------
///      8  9 | 12 13
///     10 11 | 14 15
struct BlendedMaps {
    int m = 5;
    uint32_t id[kMaxBlended]{};     ///< ids of the records
    int count = 0;                  ///< 0: no approximation available
    float beta[kMaxBlended];        ///< > 0; the sum is 1
    const Word* bits[kMaxBlended];  ///< 4^m bits
    const Word*
        hierarchy[kMaxBlended];  ///< levels 0 (root) … m − 3 one after another, node z of level l at 2·((4^l
                                 ///< − 1)/3 + z): bit 0 = any cell visible, bit 1 = all cells visible
    /// Dilated maps for sampling, in Morton order: dilated by one cell (4^m bits), by one block of 2 × 2
    /// cells (4^(m−1) bits), and for m >= 6 by one block of 4 × 4 cells (4^(m−2) bits).
    const Word* dilated[3][kMaxBlended];
};

/// Number of dilated maps used for the density.
constexpr int dilations(int m) { return m >= 6 ? 3 : 2; }

}  // namespace viscache

#pragma once
// What the records near a point say about its visibility: the seam between the cache and its users.
#include "viscache/math/bits.h"

namespace viscache {

constexpr int kMaxBlended = 8;  ///< records blended at one point, at most

/// The records that speak for one point, and their shares: Ṽ = Σ β_i V_i. Maps are 2^m × 2^m cells of the
/// equal-area octahedral map along the Morton curve: cell z is bit z % 64 of word z / 64.
struct BlendedMaps {
    int m = 5;
    uint32_t id[kMaxBlended]{};          ///< the records
    int count = 0;                       ///< 0: there is no approximation
    float beta[kMaxBlended];             ///< > 0, sum 1
    const Word* bits[kMaxBlended];       ///< 4^m bits
    const Word* hierarchy[kMaxBlended];  ///< levels 0 (root) … m − 3 one after another, node z of level l at
                                         ///< 2·((4^l − 1)/3 + z): bit 0 = any cell visible, bit 1 = all
    /// Maps grown for sampling: by one cell (4^m bits), by one block of 2 × 2 cells (4^(m−1) bits), and from
    /// m = 6 on by one of 4 × 4 (4^(m−2) bits); Morton order too.
    const Word* dilated[3][kMaxBlended];
};

/// Number of dilated maps that shape the density.
constexpr int dilations(int m) { return m >= 6 ? 3 : 2; }

}  // namespace viscache

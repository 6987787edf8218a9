#pragma once
// Computes the bin and ρ of pairs from n11, and sums the pairs of one tile.
#include <cmath>

#include "viscache/correlation/bin_edges.h"
#include "viscache/correlation/bit_panels.h"
#include "viscache/correlation/pair_table.h"
#include "viscache/math/isa.h"
#include "viscache/math/vec.h"

namespace viscache {

#define VISCACHE_INLINE inline __attribute__((always_inline))

// The formulas below take scalars or vectors of 16 lanes. They are single IEEE operations in a fixed order,
// so that all variants give the same bits. All are symmetric in the two points.

template <class F>
VISCACHE_INLINE F squared_length(F x, F y, F z) {
    return (x * x + y * y) + z * z;
}

/// T·n11 − n1·n2; below 2³¹ for T <= kMaxDirections.
/// Exact: T² < 2³¹. In float it would lose bits.
template <class I>
VISCACHE_INLINE I phi_numerator(I n11, I n1, I n2, I n_directions) {
    return n_directions * n11 - n1 * n2;
}
/// 1/√(n1 (T − n1)): the inverse spread of a row of bits; 0 if all bits are equal.
inline float inverse_spread(int32_t n1, int32_t n_directions) {
    const double product = double(n1) * double(n_directions - n1);
    return product > 0 ? float(1 / std::sqrt(product)) : 0.f;
}

/// 1.5·2²³. Adding it to |x| < 2²² rounds x to the nearest integer, ties to even, in the low bits.
/// At 1.5·2²³ floats are one apart, for sums in [2²³, 2²⁴).
constexpr float kRoundBySum = 12582912.f;
constexpr int32_t kRoundBySumBits = 0x4b400000;

/// [VisMap Sec. 4.1] ρ of the visibility of two points over T shared directions, the phi coefficient of
/// their rows of bits: (T·n11 − n1·n2) / (√(n1 (T − n1)) √(n2 (T − n2))).
template <class F>
VISCACHE_INLINE F pearson(F numerator, F inverse_spread_1, F inverse_spread_2) {
    // Each inverse spread is at least 2/T, so their product stays in the range of float; taken first, it
    // makes ρ symmetric in the two points.
    return numerator * (inverse_spread_1 * inverse_spread_2);
}
/// p = 2²⁰ + round(2²⁰·ρ), in [0, 2²¹]. |ρ| exceeds 1 only by rounding errors, which never move p out of its
/// range.
inline int32_t biased_rho(float rho) {
    return std::bit_cast<int32_t>(rho * float(kRhoOne) + kRoundBySum) - kRoundBySumBits + int32_t(kRhoOne);
}

/// Whether ρ is defined for a row; if not, the reason. kPadding is not a row of a point.
enum class RowKind : uint8_t { kDefined, kFew, kFull, kPadding };

/// The points in the order of the panels, 16 per panel, stored as columns.
struct PairPoints {
    void resize(size_t n) {
        for (std::vector<float>* v : {&x, &y, &z, &nx, &ny, &nz, &inverse_spread}) v->assign(n, 0.f);
        n1.assign(n, 0);
        kind.assign(n, RowKind::kPadding);
        ordinary.assign(n / kPanelRows, true);
    }
    std::vector<float> x, y, z, nx, ny, nz, inverse_spread;
    std::vector<int32_t> n1;
    std::vector<RowKind> kind;
    std::vector<char> ordinary;  ///< per panel: true if all its points have a defined row
};

/// The bins, and the rule for pairs without ρ.
struct PairBinning {
    KeyTable distance, angle;
    int32_t n_distances = 0, n_angles = 0, n_directions = 0;
    bool one_if_both = false;

    /// The cells have a border for pairs outside the edges. They exist twice, the second time for pairs
    /// without ρ. One more cell takes lanes that are not a pair.
    ///
    /// Distance varies fastest. The points of a panel have similar normals, so the sums that a pair of
    /// panels updates stay in the L1 cache.
    int32_t stride() const { return n_distances + 2; }
    int32_t cells() const { return (n_angles + 2) * stride(); }
    int32_t no_pair() const { return 2 * cells(); }
    int32_t cell(float squared_distance, float squared_chord) const {
        return int32_t(angle.code(chord_key(squared_chord))) * stride() +
               int32_t(distance.code(distance_key(squared_distance)));
    }
};

/// Packed sums of a cell over at most `kMaxPairs` pairs. With p = q + 2²⁰ >= 0 they are count·2⁴³ + Σp, and
/// Σp².
/// Both fit into 64 bits: p <= 2²¹ and less than 2²¹ pairs give Σp < 2⁴² and Σp² < 2⁶³.
struct alignas(16) PackedSums {
    static constexpr int kCountShift = 43;
    static constexpr uint64_t kOne = uint64_t{1} << kCountShift;
    static constexpr int64_t kMaxPairs = (int64_t{1} << (64 - kCountShift)) - 1;

    void add(int32_t p) {
        count_and_sum += kOne + uint64_t(p);
        squares += uint64_t(p) * uint64_t(p);
    }
    uint64_t count_and_sum = 0, squares = 0;
};

/// Sums of one thread over the pairs of one pair of groups.
class TileBins {
public:
    explicit TileBins(const PairBinning& binning) : binning_(binning), sums_(size_t(binning.no_pair()) + 1) {}
    const PairBinning& binning() const { return binning_; }
    PackedSums* sums() { return sums_.data(); }
    /// True if the sums must be flushed before `more` pairs are added.
    bool is_full(int64_t more) const { return pending_ + more > PackedSums::kMaxPairs; }
    void count(int64_t pairs) { pending_ += pairs; }
    /// Adds the sums to the table and clears them.
    void flush(PairTable& table, size_t group_pair);

private:
    PairBinning binning_;
    std::vector<PackedSums> sums_;
    int64_t pending_ = 0;
};

/// Bins the 16 × 16 pairs of panels a and b with the given n11. If a == b, only pairs i < j are binned.
using BinPanels = void (*)(const PairPoints& points, size_t a, size_t b, const int32_t* counts,
                           TileBins& bins);
BinPanels bin_panels(Isa isa);

/// Handles a pair for which a row has no ρ: moves it to the cell of undefined pairs, or sets ρ by the rule.
void resolve_pair(const PairBinning& binning, RowKind a, RowKind b, int32_t& cell, int32_t& biased);
/// The same for the 16 pairs of a row with a panel. Lanes that are padding, or pairs counted already, go to
/// no_pair.
void resolve_row(const PairPoints& points, const PairBinning& binning, size_t row, size_t first_column,
                 int32_t* cells, int32_t* biased);

#undef VISCACHE_INLINE

}  // namespace viscache

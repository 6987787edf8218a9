#pragma once
// From n11 to sums: the place of a pair, its ρ, its bin, and the sums of one tile of pairs.
#include <cmath>
#include <memory>

#include "viscache/correlation/bin_edges.h"
#include "viscache/correlation/bit_panels.h"
#include "viscache/correlation/pair_table.h"
#include "viscache/math/isa.h"
#include "viscache/math/vec.h"

namespace viscache {

#define VISCACHE_INLINE inline __attribute__((always_inline))

// The formulas below take floats and ints or vectors of 16 of them: single IEEE operations in one order, so
// that every variant gives the same bits. All are symmetric in the two points.

template <class F>
VISCACHE_INLINE F squared_length(F x, F y, F z) {
    return (x * x + y * y) + z * z;
}

/// T·n11 − n1·n2; below 2³¹ for T <= kMaxDirections.
template <class I>
VISCACHE_INLINE I phi_numerator(I n11, I n1, I n2, I n_directions) {
    return n_directions * n11 - n1 * n2;
}
/// 1/√(n1 (T − n1)): the spread of a row of bits; 0 where all bits are equal.
inline float inverse_spread(int32_t n1, int32_t n_directions) {
    const double product = double(n1) * double(n_directions - n1);
    return product > 0 ? float(1 / std::sqrt(product)) : 0.f;
}

/// 1.5·2²³: adding it to |x| < 2²² rounds x to the nearest integer, ties to even, kept in the low bits.
constexpr float kRoundBySum = 12582912.f;
constexpr int32_t kRoundBySumBits = 0x4b400000;

/// [VisMap Sec. 4.1] ρ of the visibility of two points over T shared directions, the phi coefficient of their
/// rows of bits: (T·n11 − n1·n2) / (√(n1 (T − n1)) √(n2 (T − n2))).
template <class F>
VISCACHE_INLINE F pearson(F numerator, F inverse_spread_1, F inverse_spread_2) {
    return numerator * (inverse_spread_1 * inverse_spread_2);
}
/// p = 2²⁰ + round(2²⁰·ρ), in [0, 2²¹]: |ρ| exceeds 1 by rounding alone, which never moves p out of its
/// range.
inline int32_t biased_rho(float rho) {
    return std::bit_cast<int32_t>(rho * float(kRhoOne) + kRoundBySum) - kRoundBySumBits + int32_t(kRhoOne);
}

/// Why a point's row has no ρ, or is no row.
enum class RowKind : uint8_t { kDefined, kFew, kFull, kPadding };

/// Points in the order of the panels, 16 to a panel, as columns.
struct PairPoints {
    void resize(size_t n) {
        for (std::vector<float>* v : {&x, &y, &z, &nx, &ny, &nz, &inverse_spread}) v->assign(n, 0.f);
        n1.assign(n, 0), kind.assign(n, RowKind::kPadding), ordinary.assign(n / kPanelRows, true);
    }
    std::vector<float> x, y, z, nx, ny, nz, inverse_spread;
    std::vector<int32_t> n1;
    std::vector<RowKind> kind;
    std::vector<char> ordinary;  ///< of a panel: every point has a defined row
};

/// Bins and the rules for pairs without ρ.
struct PairBinning {
    KeyTable distance, angle;
    int32_t n_distances = 0, n_angles = 0, n_directions = 0;
    bool one_if_both = false;

    /// Cells with a border for pairs outside the edges; twice, for pairs without ρ; and one for lanes that
    /// are no pair.
    ///
    /// Distances are next to each other: points of a panel have like normals, so that what a panel pair adds
    /// to stays in the first-level cache.
    int32_t stride() const { return n_distances + 2; }
    int32_t cells() const { return (n_angles + 2) * stride(); }
    int32_t no_pair() const { return 2 * cells(); }
    int32_t cell(float squared_distance, float squared_chord) const {
        return int32_t(angle.code(chord_key(squared_chord))) * stride() +
               int32_t(distance.code(distance_key(squared_distance)));
    }
};

/// The sums of a cell over at most `kMaxPairs` pairs, packed: with p = q + 2²⁰ >= 0, count·2⁴³ + Σp and Σp².
struct alignas(16) PackedSums {
    static constexpr int kCountShift = 43;
    static constexpr uint64_t kOne = uint64_t{1} << kCountShift;
    static constexpr int64_t kMaxPairs = (int64_t{1} << (64 - kCountShift)) - 1;

    void add(int32_t p) { count_and_sum += kOne + uint64_t(p), squares += uint64_t(p) * uint64_t(p); }
    uint64_t count_and_sum = 0, squares = 0;
};

/// Sums of the pairs of one pair of groups, of one thread.
class TileBins {
public:
    explicit TileBins(const PairBinning& binning) : binning_(binning), sums_(size_t(binning.no_pair()) + 1) {}
    const PairBinning& binning() const { return binning_; }
    PackedSums* sums() { return sums_.data(); }
    /// True if `more` pairs must not be added before the sums are flushed.
    bool is_full(int64_t more) const { return pending_ + more > PackedSums::kMaxPairs; }
    void note(int64_t pairs) { pending_ += pairs; }
    /// Adds the sums to the table and clears them.
    void flush(PairTable& table, size_t group_pair);

private:
    PairBinning binning_;
    std::vector<PackedSums> sums_;
    int64_t pending_ = 0;
};

/// Bins the 16 × 16 pairs of the panels a and b with the given n11; of a panel with itself only i < j.
using BinPanels = void (*)(const PairPoints& points, size_t a, size_t b, const int32_t* counts,
                           TileBins& bins);
BinPanels bin_panels(Isa isa);

/// Moves a pair of points without ρ to the cell where it is counted, or gives it the ρ the rule says.
void settle_pair(const PairBinning& binning, RowKind a, RowKind b, int32_t& cell, int32_t& biased);
/// The same for the 16 pairs of a row with a panel; lanes that are padding or counted already go to no_pair.
void settle_row(const PairPoints& points, const PairBinning& binning, size_t row, size_t first_column,
                int32_t* cells, int32_t* biased);

#undef VISCACHE_INLINE

}  // namespace viscache

#pragma once
// The input of pair statistics: points with rows of bits, and the domain of directions over which ρ is
// taken.
#include <span>

#include "viscache/correlation/pair_bins.h"
#include "viscache/math/bits.h"

namespace viscache {

/// Directions over which ρ of a pair is taken: all; those above both tangent planes; those above at least
/// one.
enum class PairDomain { kSphere, kJoint, kUnion };

/// N points and their rows of bits. Row i starts at bits + i·words; padding bits are 0.
struct PairRows {
    const Word* bits = nullptr;
    size_t words = 0;
    int32_t n_directions = 0;
    std::span<const Vec3> position, normal;
    std::span<const int32_t> group;
    size_t n_groups = 1;
    PairDomain domain = PairDomain::kSphere;
    std::span<const Vec3>
        direction;             ///< the direction of every bit; required unless the domain is the sphere
    int32_t min_bits = 1;      ///< a row with fewer set bits has no ρ
    bool one_if_both = false;  ///< ρ = 1 if both rows have no ρ for the same reason

    size_t size() const { return position.size(); }
    const Word* row(size_t i) const { return bits + i * words; }
    /// Throws std::invalid_argument that says what is wrong.
    void check() const;
    RowKind kind(int32_t n1, int32_t of) const {
        return n1 < min_bits ? RowKind::kFew : n1 == of ? RowKind::kFull : RowKind::kDefined;
    }
    /// Sets the bits of the directions above the tangent plane of point i, n·ω > 0.
    void above(size_t i, Word* row) const;
    /// Row i restricted to the domain: bits below the tangent plane are 0 unless the domain is the sphere.
    void visible(size_t i, Word* row) const;
};

/// Maximum number of bins of distance and angle together: 64 MiB of sums per thread.
constexpr size_t kMaxBins = size_t{1} << 21;

/// Bins by the given edges, with the rules of the rows.
PairBinning binning_of(const PairRows& rows, const BinEdges& distances, const BinEdges& angles);

/// Counts of a pair; its domain has `of` directions.
struct DomainCounts {
    int32_t of = 0, n1 = 0, n2 = 0, n11 = 0;
};

/// Counts from the sizes of intersections. v is what a point sees, u is what lies above its tangent plane:
/// v1·v2, v1·u2, u1·v2, u1·u2, and the sizes of v1, v2 and u1 + u2.
DomainCounts domain_counts(PairDomain domain, int32_t vv, int32_t vu, int32_t uv, int32_t uu, int32_t v1,
                           int32_t v2, int32_t u1_and_u2);

/// Sets p, or the cell of a pair without ρ, from the counts within the domain.
void resolve_counts(const PairRows& rows, const PairBinning& binning, const DomainCounts& c, int32_t& cell,
                    int32_t& biased);

}  // namespace viscache

#pragma once
// What pair statistics are taken over: points with rows of bits, and the part of the sphere that counts.
#include <span>

#include "viscache/correlation/pair_bins.h"
#include "viscache/math/bits.h"

namespace viscache {

/// Directions over which ρ of a pair is taken: all; those above both points' planes; those above either's.
enum class PairDomain { kSphere, kJoint, kUnion };

/// N points and their rows of bits, row i at bits + i·words; padding bits 0.
struct PairRows {
    const Word* bits = nullptr;
    size_t words = 0;
    int32_t n_directions = 0;
    std::span<const Vec3> position, normal;
    std::span<const int32_t> group;
    size_t n_groups = 1;
    PairDomain domain = PairDomain::kSphere;
    std::span<const Vec3> direction;  ///< of every bit; needed unless the domain is the sphere
    int32_t min_bits = 1;             ///< a row with fewer set bits has no ρ
    bool one_if_both = false;         ///< ρ = 1 where both rows have none, for the same reason

    size_t size() const { return position.size(); }
    const Word* row(size_t i) const { return bits + i * words; }
    /// Throws std::invalid_argument that names what is wrong.
    void check() const;
    RowKind kind(int32_t n1, int32_t of) const {
        return n1 < min_bits ? RowKind::kFew : n1 == of ? RowKind::kFull : RowKind::kDefined;
    }
    /// The directions above the plane of point i, n·ω > 0.
    void above(size_t i, Word* row) const;
    /// Row i as it counts: its bits, below its own plane 0 unless the domain is the sphere.
    void visible(size_t i, Word* row) const;
};

/// Bins of distance and angle together: 64 MiB of sums for every thread.
constexpr size_t kMaxBins = size_t{1} << 21;

/// Bins by the edges, with the rules of the rows.
PairBinning binning_of(const PairRows& rows, const BinEdges& distances, const BinEdges& angles);

/// Counts of a pair within its domain of `of` directions.
struct DomainCounts {
    int32_t of = 0, n1 = 0, n2 = 0, n11 = 0;
};

/// From intersections of what the points see (v) and what lies above their planes (u): v1·v2, v1·u2, u1·v2,
/// u1·u2, and from the sizes of v1, v2, u1 + u2.
DomainCounts domain_counts(PairDomain domain, int32_t vv, int32_t vu, int32_t uv, int32_t uu, int32_t v1,
                           int32_t v2, int32_t u1_and_u2);

/// Settles cell and p of a pair from its counts within its domain.
void settle_counts(const PairRows& rows, const PairBinning& binning, const DomainCounts& c, int32_t& cell,
                   int32_t& biased);

}  // namespace viscache

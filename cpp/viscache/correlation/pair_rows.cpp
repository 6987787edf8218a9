#include "viscache/correlation/pair_rows.h"

#include <stdexcept>
#include <string>

namespace viscache {
namespace {

[[noreturn]] void refuse(const std::string& what) { throw std::invalid_argument(what); }

void check_points(const PairRows& rows) {
    if (rows.normal.size() != rows.size() || rows.group.size() != rows.size())
        refuse("normals and group must have one row per position, got " + std::to_string(rows.normal.size()) +
               " and " + std::to_string(rows.group.size()) + " for " + std::to_string(rows.size()));
    if (rows.size() >= kNoPoint) refuse("there must be less than 2^32 points");
    for (size_t i = 0; i < rows.size(); ++i) {
        if (!is_finite(rows.position[i]))
            refuse("positions must be finite, row " + std::to_string(i) + " is not");
        // Normals need not be exact: chords are compared in bins.
        if (!(std::fabs(length2(rows.normal[i]) - 1) < 1e-3f))
            refuse("normals must be unit vectors, row " + std::to_string(i) + " has length " +
                   std::to_string(length(rows.normal[i])));
    }
}

void check_bits(const PairRows& rows) {
    if (rows.n_directions < 1 || size_t(rows.n_directions) > kMaxDirections)
        refuse("n_directions must lie in [1, " + std::to_string(kMaxDirections) + "], got " +
               std::to_string(rows.n_directions));
    const size_t full = size_t(rows.n_directions) / kWordBits, rest = size_t(rows.n_directions) % kWordBits;
    if (words_for(size_t(rows.n_directions)) > rows.words)
        refuse("bits must have " + std::to_string(words_for(size_t(rows.n_directions))) +
               " words or more a row for " + std::to_string(rows.n_directions) + " directions, got " +
               std::to_string(rows.words));
    for (size_t i = 0; i < rows.size(); ++i)
        for (size_t w = full; w < rows.words; ++w)
            // In the last word, bits from `rest` on; in words past it, all.
            if (rows.row(i)[w] & (w == full ? ~Word{0} << rest : ~Word{0}))
                refuse("bits past n_directions must be 0, row " + std::to_string(i) + " has some set");
}

}  // namespace

void PairRows::check() const {
    if (min_bits < 1) refuse("min_bits must be >= 1, got " + std::to_string(min_bits));
    check_bits(*this);
    check_points(*this);
    if (domain != PairDomain::kSphere && direction.size() != size_t(n_directions))
        refuse("directions must have one row per bit, " + std::to_string(n_directions) + ", got " +
               std::to_string(direction.size()));
    for (size_t k = 0; k < direction.size(); ++k)
        if (!is_finite(direction[k]))
            refuse("directions must be finite, row " + std::to_string(k) + " is not");
}

void PairRows::above(size_t i, Word* row) const {
    for (size_t k = 0; k < direction.size(); ++k)
        // Strictly above: a direction in the tangent plane meets no bit of the row.
        if (dot(normal[i], direction[k]) > 0) set_bit(row, k);
}

void PairRows::visible(size_t i, Word* out) const {
    if (domain == PairDomain::kSphere) {
        std::copy_n(row(i), words, out);
        return;
    }
    std::fill_n(out, words, 0);
    above(i, out);
    for (size_t w = 0; w < words; ++w) out[w] &= row(i)[w];
}

PairBinning binning_of(const PairRows& rows, const BinEdges& distances, const BinEdges& angles) {
    if (distances.bins() * angles.bins() > kMaxBins)
        refuse("d_edges and theta_edges_deg must make at most " + std::to_string(kMaxBins) + " bins, got " +
               std::to_string(distances.bins() * angles.bins()));
    return {.distance = distances.table(),
            .angle = angles.table(),
            .n_distances = int32_t(distances.bins()),
            .n_angles = int32_t(angles.bins()),
            .n_directions = rows.n_directions,
            .one_if_both = rows.one_if_both};
}

DomainCounts domain_counts(PairDomain domain, int32_t vv, int32_t vu, int32_t uv, int32_t uu, int32_t v1,
                           int32_t v2, int32_t u1_and_u2) {
    // All directions that a point sees are above its own plane, so the union contains all of them
    // |u₁ ∪ u₂| = |u₁| + |u₂| − |u₁ ∩ u₂|
    if (domain == PairDomain::kUnion) return {u1_and_u2 - uu, v1, v2, vv};
    return {uu, vu, uv, vv};
}

void resolve_counts(const PairRows& rows, const PairBinning& binning, const DomainCounts& c, int32_t& cell,
                    int32_t& biased) {
    const RowKind kind1 = rows.kind(c.n1, c.of), kind2 = rows.kind(c.n2, c.of);
    if (kind1 == RowKind::kDefined && kind2 == RowKind::kDefined) {
        // Numbers of the domain differ from pair to pair, so nothing can be prepared per row. In 64 bits:
        // exact.
        const auto of = int64_t(c.of), n1 = int64_t(c.n1), n2 = int64_t(c.n2);
        const double spread = std::sqrt(double(n1 * (of - n1))) * std::sqrt(double(n2 * (of - n2)));
        biased = biased_rho(float(double(of * c.n11 - n1 * n2) / spread));
    } else {
        resolve_pair(binning, kind1, kind2, cell, biased);
    }
}

}  // namespace viscache

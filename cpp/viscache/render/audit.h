#pragma once
// Audits of a frame whose oracle approximates: exact rays answer some of its queries as well. What is drawn
// depends on the frame alone, and the frame has the same bytes with and without an audit.
#include <array>

#include "viscache/render/tile_contributions.h"

namespace viscache {

/// An audited pixel: answered minus exact light of each light group.
struct AuditedPixel {
    double weight = 0;
    std::array<Rgb, kLightGroups> error{};
};

/// Audited queries of a light group. Contributions c are sums over channels; c of a wrong answer counts
/// positive if the oracle saw what is hidden.
struct AuditedQueries {
    uint64_t exact = 0;                            ///< answered by exact rays: no need to audit them
    uint64_t queries = 0;                          ///< all others
    uint64_t certain = 0, certain_wrong = 0;       ///< always audited: c above the limit
    uint64_t sampled = 0, sampled_wrong = 0;       ///< audited at random, of the others
    double certain_error = 0;                      ///< Σ c of wrong answers
    double sampled_error = 0, sampled_square = 0;  ///< Σ c, Σ c² of wrong answers
    double sampled_fourth = 0;                     ///< Σ c⁴
};

/// What an audit of queries found in a tile.
struct AuditRecords {
    std::array<AuditedQueries, kLightGroups> queries{};
    uint64_t rays = 0;
};

}  // namespace viscache

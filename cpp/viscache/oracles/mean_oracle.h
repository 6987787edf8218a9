#pragma once
// The mean visibility of a pair of voxels as a control variate: mean + (V - mean)/q for a random share q of
// the queries, which are traced.
//
// Kugelmann's VisCache ("prediction with correction") has the same form. q follows c·sqrt(mean·(1 − mean)),
// where c is the unoccluded contribution: then no correction weighs much more than another. All answers have
// weights. Without a share, samples that belong to one eye point and groups of few lights are all traced:
// rays are a small part of their cost, and the noise of draws would be most of the error. Roulette, the form
// of the paper, traces with q and counts 0 for the others.
#include <array>
#include <optional>

#include "viscache/oracles/exact.h"
#include "viscache/oracles/random_share.h"
#include "viscache/oracles/voxel_rows.h"

namespace viscache {

struct MeanSettings {
    /// q in (0, 1]; empty: by contribution and mean, a power of two of at least 2^−kHalvings.
    std::optional<double> share;
    /// Without a share: q reaches 1 at this share of the eye point's unoccluded light from the group, where
    /// the mean visibility is 1/2.
    double certain = 1.0 / 256;
    uint64_t seed = 0;
    /// The seed of all frames that go on from each other. A query with q = 2^−h is drawn in one of 2^h
    /// samples of its pixel that follow each other.
    uint64_t lasting_seed = 0;
    /// Without weights, a correction counts as if q were 1. This is biased on purpose, for tests that must
    /// detect it.
    bool weighted = true;
    static constexpr size_t kHalvings = 5;
    static constexpr size_t kFewLights = 8;
};

class MeanOracle final : public VisibilityOracle {
public:
    /// `map` must outlive the oracle and is only read.
    MeanOracle(const VoxelVisibility& map, const RayCaster& caster, const MeanSettings& settings);

    void begin_tile(const EyeBlock& eyes) override { exact_.begin_tile(eyes); }
    Answer block(const BlockAsk& ask, Counters& counters) override;
    Answer pairs(const PairsAsk& ask, Counters& counters) override;

private:
    static constexpr size_t kPlanes = MeanSettings::kHalvings;
    bool traces_all() const { return share_ && *share_ >= 1; }
    Answer traced(Answer exact, uint64_t rays_before, Counters& counters) const;
    void make_rows(const BlockAsk& ask);
    void draw_evenly(const BlockAsk& ask, uint32_t eye);
    void draw_by_contribution(const BlockAsk& ask, uint32_t eye);

    const VoxelVisibility& map_;
    ExactOracle exact_;
    std::optional<double> share_;
    /// Bounds of contributions. A connection below h of them is drawn with at most q = 2^−h.
    std::array<float, kPlanes> bands_below_;
    EyeKeys keys_;
    bool weighted_;
    std::vector<float> weights_;  ///< means of the columns of each voxel; of pairs, corrected
    std::vector<float> inverse_;  ///< 1/q of each drawn query, in their order
    // For `block`
    VoxelRows voxels_;
    /// Of each voxel, kPlanes rows of words. Plane j has the columns whose deviation, sqrt(mean·(1 − mean)),
    /// is at most 2^−(j + 2).
    std::vector<Word> steady_;
    BitMatrix drawn_, bands_, planes_;
    std::vector<uint32_t> correction_begin_;  ///< by eye point
    std::vector<Correction> corrections_;
};

}  // namespace viscache

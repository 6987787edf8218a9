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
#include <memory>
#include <optional>

#include "viscache/visibility/exact.h"
#include "viscache/visibility/voxel_visibility.h"

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
    MeanOracle(const VoxelVisibility& map, const RayCaster& caster, float extent,
               const MeanSettings& settings);

    void watch(const Control& control) override;
    void weigh(const Contributions* contributions) override { contributions_ = contributions; }
    void begin_tile(const EyeBlock& eyes) override { exact_.begin_tile(eyes); }
    void block(const EyeBlock& eyes, const FarEnds& lights, const BitMatrix& wanted, BitMatrix& visible,
               Counters& counters) override;
    void pairs(const EyeBlock& eyes, std::span<const ShadowQuery> queries, std::span<Word> visible,
               Counters& counters) override;
    void samples(const EyeBlock& eyes, const LocalSamples& samples, std::span<Word> visible,
                 Counters& counters) override;
    bool is_exact(const FarEnds& lights) const override {
        return share_ ? is_exact() : lights.count <= MeanSettings::kFewLights;
    }
    bool is_exact_own(int) const override { return !share_ || is_exact(); }
    std::span<const float> block_weights(uint32_t eye) const override {
        return traced_all_ ? std::span<const float>{} : rows_[row_of_eye_[eye]]->mean;
    }
    std::span<const Correction> block_corrections(uint32_t eye) const override {
        if (correction_begin_.empty()) return {};
        return std::span(corrections_)
            .subspan(correction_begin_[eye], correction_begin_[eye + 1] - correction_begin_[eye]);
    }
    std::span<const float> pair_weights() const override {
        return is_exact() ? std::span<const float>{} : std::span<const float>(pair_weights_);
    }

private:
    static constexpr uint32_t kNone = ~uint32_t{0};
    static constexpr size_t kPlanes = MeanSettings::kHalvings;
    /// The columns of a block for one voxel.
    struct Row {
        uint32_t voxel = 0;
        std::vector<float> mean;
        /// Plane j has the columns whose deviation, sqrt(mean·(1 − mean)), is at most 2^−(j + 2).
        std::array<std::vector<Word>, kPlanes> steady;
    };
    bool is_exact() const { return share_ && *share_ >= 1; }
    uint64_t eye_key(const EyeBlock& eyes, size_t eye, int group) const;
    void make_rows(const EyeBlock& eyes, const FarEnds& lights);
    void draw_evenly(const EyeBlock& eyes, uint32_t eye, int group, const BitMatrix& wanted);
    void draw_by_contribution(const EyeBlock& eyes, uint32_t eye, int group, const BitMatrix& wanted);

    const VoxelVisibility& map_;
    ExactOracle exact_;
    std::optional<double> share_;
    /// Bounds of contributions. A connection below h of them is drawn with at most q = 2^−h.
    std::array<float, kPlanes> bands_below_;
    uint64_t seed_, lasting_seed_;
    bool weighted_;
    const Contributions* contributions_ = nullptr;
    // For `block`
    bool traced_all_ = false;  ///< the latest block
    std::vector<uint32_t> row_of_voxel_, row_of_eye_, far_;
    std::vector<std::unique_ptr<Row>> rows_;
    BitMatrix drawn_, seen_, bands_, planes_;
    std::vector<float> inverse_;              ///< 1/q of each drawn query, in their order
    std::vector<uint32_t> correction_begin_;  ///< by eye point
    std::vector<Correction> corrections_;
    // For `pairs`
    std::vector<float> pair_weights_;
};

}  // namespace viscache

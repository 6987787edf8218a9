#pragma once
// Next Event Estimation++ (Guo, Eisemann, Eisemann 2020) as oracles: one learns the map of visibilities, one
// plays Russian roulette with it. A connection is traced with a probability q that grows with its estimated
// visibility; what is seen counts 1/q, what is left out is answered "blocked". Without bias, with noise.
#include <memory>

#include "viscache/visibility/exact.h"
#include "viscache/visibility/voxel_visibility.h"

namespace viscache {

/// Exact answers, each of which is added to the map.
class LearningOracle final : public VisibilityOracle {
public:
    /// `map` must outlive the oracle and may be shared by several.
    LearningOracle(VoxelVisibility& map, const RayCaster& caster, float extent)
        : map_(map), exact_(caster, extent) {}

    void watch(const Control& control) override;
    void begin_tile(const EyeBlock&) override {}
    void block(const EyeBlock& eyes, const FarEnds& lights, const BitMatrix& wanted, BitMatrix& visible,
               Counters& counters) override;
    void pairs(const EyeBlock& eyes, std::span<const ShadowQuery> queries, std::span<Word> visible,
               Counters& counters) override;

private:
    VoxelVisibility& map_;
    ExactOracle exact_;
};

/// Answers that carry weights.
class RouletteOracle final : public VisibilityOracle {
public:
    /// `map` must outlive the oracle, and is only read.
    /// Without `weighted` what is seen counts 1, which is wrong: for tests that must notice.
    RouletteOracle(const VoxelVisibility& map, const RayCaster& caster, float extent, uint64_t seed,
                   bool weighted = true)
        : map_(map),
          exact_(caster, extent),
          seed_(seed),
          weighted_(weighted),
          row_of_voxel_(map.voxels(), kNone) {}

    void watch(const Control& control) override;
    void begin_tile(const EyeBlock&) override {}
    void block(const EyeBlock& eyes, const FarEnds& lights, const BitMatrix& wanted, BitMatrix& visible,
               Counters& counters) override;
    void pairs(const EyeBlock& eyes, std::span<const ShadowQuery> queries, std::span<Word> visible,
               Counters& counters) override;
    std::span<const float> block_weights(uint32_t eye) const override {
        return weighted_ ? std::span<const float>(rows_[row_of_eye_[eye]]->weight) : std::span<const float>{};
    }
    std::span<const float> pair_weights() const override {
        return weighted_ ? std::span<const float>(weight_) : std::span<const float>{};
    }

private:
    static constexpr uint32_t kNone = ~uint32_t{0};
    /// One voxel's probabilities of a block's columns; a number of 32 random bits passes if it is not larger.
    struct Row {
        uint32_t voxel = 0;
        std::vector<uint32_t> threshold;
        std::vector<float> weight;
    };
    void make_rows(const EyeBlock& eyes, const FarEnds& lights);
    void keep_row(const EyeBlock& eyes, size_t eye, const FarEnds& lights, const Word* wanted,
                  Word* kept) const;
    uint64_t eye_key(const EyeBlock& eyes, size_t eye, int group) const;

    const VoxelVisibility& map_;
    ExactOracle exact_;
    uint64_t seed_;
    bool weighted_;
    // Of `block`
    std::vector<uint32_t> row_of_voxel_, row_of_eye_, far_;
    std::vector<std::unique_ptr<Row>> rows_;
    BitMatrix kept_;
    // Of `pairs`
    std::vector<float> weight_;
    std::vector<uint32_t> asked_;
    std::vector<ShadowQuery> queries_;
    std::vector<Word> answer_;
};

}  // namespace viscache

#pragma once
// Next Event Estimation++ (Guo, Eisemann, Eisemann 2020) as two oracles: one learns a map of visibilities,
// the other uses it for Russian roulette. A connection is traced with a probability q that grows with its
// estimated visibility. A visible connection has weight 1/q; a connection that is not traced counts as
// blocked. The result is unbiased but has noise.
#include <memory>

#include "viscache/visibility/exact.h"
#include "viscache/visibility/kept_voxels.h"

namespace viscache {

/// Answers exactly and adds each answer to the map.
class LearningOracle final : public VisibilityOracle {
public:
    /// `map` must outlive the oracle and may be shared by several. `journal`: records what was added.
    LearningOracle(VoxelVisibility& map, const RayCaster& caster, float extent,
                   VoxelJournal::Entries* journal = nullptr)
        : map_(map), exact_(caster, extent), journal_(journal) {}

    void watch(const Control& control) override;
    void begin_tile(const EyeBlock& eyes) override { exact_.begin_tile(eyes); }
    void block(const EyeBlock& eyes, const FarEnds& lights, const BitMatrix& wanted, BitMatrix& visible,
               Counters& counters) override;
    void pairs(const EyeBlock& eyes, std::span<const ShadowQuery> queries, std::span<Word> visible,
               Counters& counters) override;

private:
    void add(uint32_t voxel, uint32_t far, bool seen) {
        const size_t place = map_.place(voxel, far);
        map_.add_at(place, seen);
        if (journal_) journal_->push_back(uint64_t(place) << 1 | uint64_t(seen));
    }

    VoxelVisibility& map_;
    ExactOracle exact_;
    VoxelJournal::Entries* journal_;
};

/// Answers with weights.
class RouletteOracle final : public VisibilityOracle {
public:
    /// `map` must outlive the oracle and is only read. Without `weighted`, visible connections have weight 1.
    /// This is biased on purpose, for tests that must detect it.
    RouletteOracle(const VoxelVisibility& map, const RayCaster& caster, float extent, uint64_t seed,
                   bool weighted = true)
        : map_(map),
          exact_(caster, extent),
          seed_(seed),
          weighted_(weighted),
          row_of_voxel_(map.voxels(), kNone) {}

    void watch(const Control& control) override;
    void begin_tile(const EyeBlock& eyes) override { exact_.begin_tile(eyes); }
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
    /// Probabilities of the columns of a block for one voxel. A column is traced if 32 random bits are at
    /// most its threshold.
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
    // For `block`
    std::vector<uint32_t> row_of_voxel_, row_of_eye_, far_;
    std::vector<std::unique_ptr<Row>> rows_;
    BitMatrix kept_;
    // For `pairs`
    std::vector<float> weight_;
    std::vector<uint32_t> traced_;
    std::vector<ShadowQuery> queries_;
    std::vector<Word> answer_;
};

}  // namespace viscache

#pragma once
// Next Event Estimation++ (Guo, Eisemann, Eisemann 2020) as two oracles: one learns a map of visibilities,
// the other uses it for Russian roulette. A connection is traced with a probability q that grows with its
// estimated visibility. A visible connection has weight 1/q; a connection that is not traced counts as
// blocked. The result is unbiased but has noise.
#include "viscache/oracles/exact.h"
#include "viscache/oracles/kept_voxels.h"
#include "viscache/oracles/random_share.h"
#include "viscache/oracles/voxel_rows.h"

namespace viscache {

/// Answers exactly and adds each answer to the map.
class LearningOracle final : public VisibilityOracle {
public:
    /// `map` must outlive the oracle and may be shared by several. `journal`: records what was added.
    LearningOracle(VoxelVisibility& map, const RayCaster& caster, VoxelJournal::Entries* journal = nullptr)
        : map_(map), exact_(caster), journal_(journal) {
        wrap(exact_);
    }

    void begin_tile(const EyeBlock& eyes) override { exact_.begin_tile(eyes); }
    Answer block(const BlockAsk& ask, Counters& counters) override;
    Answer pairs(const PairsAsk& ask, Counters& counters) override;

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
    RouletteOracle(const VoxelVisibility& map, const RayCaster& caster, uint64_t seed, bool weighted = true)
        : map_(map), exact_(caster), keys_{seed, Purpose::kRoulette}, weighted_(weighted), voxels_(map) {
        wrap(exact_);
    }

    void begin_tile(const EyeBlock& eyes) override { exact_.begin_tile(eyes); }
    Answer block(const BlockAsk& ask, Counters& counters) override;
    Answer pairs(const PairsAsk& ask, Counters& counters) override;

private:
    void make_rows(const BlockAsk& ask);
    void draw_row(const BlockAsk& ask, size_t eye, Word* drawn) const;
    std::span<const float> weights() const {
        return weighted_ ? std::span<const float>(weights_) : std::span<const float>();
    }

    const VoxelVisibility& map_;
    ExactOracle exact_;
    EyeKeys keys_;
    bool weighted_;
    std::vector<float> weights_;  ///< 1/q of the columns of each voxel, or of pairs
    // For `block`. A column is traced if 32 random bits are at most its threshold
    VoxelRows voxels_;
    std::vector<uint32_t> thresholds_;  ///< of each voxel; rows are whole words long
    BitMatrix drawn_;
    // For `pairs`: those that are traced, and their numbers
    std::vector<uint32_t> number_;
    std::vector<ShadowQuery> made_, traced_;
};

}  // namespace viscache

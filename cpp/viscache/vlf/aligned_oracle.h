#pragma once
// Exact visibility whose shared directions may go through the batch.
#include "viscache/visibility/exact.h"
#include "viscache/vlf/direction_block.h"

namespace viscache {

/// The exact oracle, but that blocks of shared directions (a sky's, say) are traced by the batch, where that
/// is asked for or predicted to be cheaper. Answers may differ from the exact oracle's for rays within
/// rounding of an edge. The choice depends on the block alone.
class AlignedOracle final : public VisibilityOracle {
public:
    /// With `choose`, the engine is chosen block by block; otherwise it is the batch, but for points too far
    /// away from it.
    AlignedOracle(const AlignedBatch& batch, const ExactOracle& exact, bool choose)
        : batch_(batch), exact_(exact), choose_(choose) {}

    void watch(const Control& control) override;
    void begin_tile(const EyeBlock& eyes) override { exact_.begin_tile(eyes); }
    void block(const EyeBlock& eyes, const FarEnds& lights, const BitMatrix& wanted, BitMatrix& visible,
               Counters& counters) override;
    void pairs(const EyeBlock& eyes, std::span<const ShadowQuery> queries, std::span<Word> visible,
               Counters& counters) override {
        exact_.pairs(eyes, queries, visible, counters);
    }
    void samples(const EyeBlock& eyes, const LocalSamples& samples, std::span<Word> visible,
                 Counters& counters) override {
        exact_.samples(eyes, samples, visible, counters);
    }

private:
    bool by_batch(const EyeBlock& eyes, const FarEnds& lights, const BitMatrix& wanted, BitMatrix& visible,
                  Counters& counters);

    const AlignedBatch& batch_;
    ExactOracle exact_;
    bool choose_;
    Control unwatched_;
    const Control* control_ = &unwatched_;
};

}  // namespace viscache

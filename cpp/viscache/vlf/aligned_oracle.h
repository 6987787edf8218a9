#pragma once
// Exact visibility that may trace shared directions with the aligned batch.
#include "viscache/oracles/exact.h"
#include "viscache/vlf/direction_block.h"

namespace viscache {

/// The exact oracle, except that blocks of shared directions (such as a sky) are traced by the batch, if
/// requested or predicted to be cheaper. Answers may differ from those of the exact oracle for rays within
/// rounding error of an edge, so no answer says that it is exact. The choice depends only on the block.
class AlignedOracle final : public VisibilityOracle {
public:
    /// With `choose`, the engine is chosen for every block. Without it, the batch traces all blocks except
    /// those with points that are too far away for it.
    AlignedOracle(const AlignedBatch& batch, ExactOracle exact, bool choose)
        : batch_(batch), exact_(std::move(exact)), choose_(choose) {
        wrap(exact_);
    }

    void begin_tile(const EyeBlock& eyes) override { exact_.begin_tile(eyes); }
    Answer block(const BlockAsk& ask, Counters& counters) override;
    // Passes on only the bits: answers of this oracle do not claim to be exact.
    Answer pairs(const PairsAsk& ask, Counters& counters) override {
        return {.bits = exact_.pairs(ask, counters).bits};
    }

private:
    BitMatrix* by_batch(const BlockAsk& ask, Counters& counters);

    const AlignedBatch& batch_;
    ExactOracle exact_;
    bool choose_;
};

}  // namespace viscache

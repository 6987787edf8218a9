#pragma once
// Rows of visibility through the engine that is cheaper.
#include "viscache/visibility/visibility_rows.h"
#include "viscache/vlf/direction_block.h"

namespace viscache {

struct AlignedRows {
    uint64_t rays = 0;
    EngineChoice choice;  ///< without predictions where nothing had to be predicted
};

/// Who shall trace; without an engine, the one that is predicted to be cheaper.
struct AlignedWish {
    std::optional<AlignedEngine> engine;
    Isa isa = active_isa();
};

/// The bits of `visibility_rows`, but for rays within rounding of an edge, by the engine wished for or
/// predicted to be cheaper; the choice depends on scene and points alone. Points go through the batch in
/// runs of 2^14, all directions of a run in one block. Throws std::invalid_argument if the batch is wished
/// for and points lie farther than 1e9 times the scene's size from it.
AlignedRows aligned_rows(const AlignedBatch& batch, const RayCaster& caster, float extent,
                         const RowInput& input, std::span<Word> rows, const AlignedWish& wish, int threads,
                         Control& control);

}  // namespace viscache

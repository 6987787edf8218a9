#pragma once
// Rows of visibility, traced by the cheaper engine.
#include "viscache/oracles/visibility_rows.h"
#include "viscache/vlf/direction_block.h"

namespace viscache {

struct AlignedRows {
    uint64_t rays = 0;
    EngineChoice choice;  ///< without predictions if the engine was given or there was nothing to trace
};

/// The requested engine. Without one, the engine that is predicted to be cheaper.
struct AlignedWish {
    std::optional<AlignedEngine> engine;
    Isa isa = active_isa();
};

/// The bits of `visibility_rows`, except for rays within rounding error of an edge, traced by the requested
/// engine or by the one predicted to be cheaper. The choice depends only on the scene and the points. The
/// batch takes points in runs of 2^14, with all directions of a run in one block. Throws
/// std::invalid_argument if the batch is requested and points lie farther from the scene than 1e9 times its
/// size.
AlignedRows aligned_rows(const AlignedBatch& batch, const RayCaster& caster, float extent,
                         const RowInput& input, std::span<Word> rows, const AlignedWish& wish, int threads,
                         Control& control);

}  // namespace viscache

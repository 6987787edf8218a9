#pragma once
// Alg. 2 in pixel order for a whole light group at once: an exact, tile-cleared table laid out as bit rows.
//
// With batch = 1 the answers, and the rays of every level, are those of Alg. 2 asked one query at a time.
// Larger batches read the rows as they were before the batch, then trace and commit its misses in processing
// order.
#include <vector>

#include "viscache/aqvc/cell_steps.h"
#include "viscache/aqvc/columns.h"
#include "viscache/aqvc/miss_tracer.h"
#include "viscache/aqvc/pixel_order.h"
#include "viscache/aqvc/row_kernels.h"
#include "viscache/aqvc/tile_anchors.h"
#include "viscache/aqvc/tile_table.h"

namespace viscache {

class Rows {
public:
    /// Answers the columns' bits into `visible` (eye points × columns, zeroed). Returns the number of rays.
    uint64_t run(const TileAnchors& tile, const TileOrder& order, uint32_t batch, const Columns& columns,
                 const std::vector<double>& levels, MissTracer& tracer, BitMatrix& visible,
                 Counters& counters, ClampCounts& clamps);

private:
    /// Misses of one eye point at one cell: row `entry` of miss_.
    struct Entry {
        uint32_t eye, row, level;
    };
    void walk(uint32_t eye, const CellGrid& grid, BitMatrix& visible, Counters& counters);
    uint64_t commit(const EyeBlock& eyes, const Columns& columns, MissTracer& tracer, BitMatrix& visible,
                    Counters& counters);
    RowPair row(uint32_t r) const { return {known_.row(r), value_.row(r)}; }

    const RowKernels& kernels_ = row_kernels(active_isa());
    size_t words_ = 0;
    CellSteps cells_;
    std::vector<Entry> entries_;  ///< of the batch
    BitMatrix known_, value_, pending_, miss_, active_;
    BitMatrix doubt_;  ///< room for a neighbour that disagrees
    std::vector<Word> fresh_;
};

}  // namespace viscache

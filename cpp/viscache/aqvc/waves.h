#pragma once
// Level waves: Alg. 2 for all eye points and lights of a block at once, level by level from coarse to fine.
//
// Differs from the pixel order of AQVC: all values of a level are known before anything is refined, so there
// is no processing order and nearly no unknown neighbour. Each cell is asked through one representative, the
// eye point nearest its centre. Per level:
//   1. trace the representatives' wanted bits that are unknown, sorted by light (those that are due, where
//      contributions are weighed: contribution_levels.h);
//   2. store each answer in the finer cells that hold the same eye point as well;
//   3. per cell: disagree = OR over four neighbours of known_n & (value_n ^ value) | ~known;
//   4. per eye point: settle the bits on which the cell agrees, want the rest at the next level.
// What is left at the end, wanted by eye points but not by their representative, is traced for the first of
// them.
#include <vector>

#include "viscache/aqvc/columns.h"
#include "viscache/aqvc/contribution_levels.h"
#include "viscache/aqvc/miss_tracer.h"
#include "viscache/aqvc/row_kernels.h"
#include "viscache/aqvc/tile_anchors.h"
#include "viscache/aqvc/tile_cells.h"

namespace viscache {

class Waves {
public:
    /// Answers the columns' bits into `visible` (eye points × columns, zeroed). Returns the number of rays.
    /// `log` may be nullptr.
    uint64_t run(const TileAnchors& tile, const TileCells& tile_cells, const Columns& columns,
                 ContributionLevels& worth, MissTracer& tracer, BitMatrix& visible, Counters& counters,
                 QueryLog* log);

private:
    uint64_t trace_level(size_t level, const EyeBlock& eyes, const Columns& columns, MissTracer& tracer);
    void write_down(size_t level);
    void settle_level(size_t level, BitMatrix& visible, Counters& counters);
    uint64_t finish(const EyeBlock& eyes, const Columns& columns, MissTracer& tracer, BitMatrix& visible,
                    Counters& counters);

    /// Runs `answer`, which resolves some of an eye point's bits from a cell, and logs these.
    template <class Answer>
    auto logged(uint32_t eye, uint32_t cell, size_t level, Answer answer);

    RowPair row(uint32_t cell) const { return {known_.row(cell), value_.row(cell)}; }

    const RowKernels& kernels_ = row_kernels(active_isa());
    size_t eyes_ = 0, levels_ = 0, words_ = 0;
    const TileCells* cells_ = nullptr;
    ContributionLevels* worth_ = nullptr;
    const Columns* columns_ = nullptr;
    QueryLog* log_ = nullptr;
    std::vector<uint32_t> asker_;  ///< with a log: the eye point whose ray answered [cell][column]
    std::vector<Word> before_;     ///< with a log: an eye point's bits before they are resolved
    /// Rows of bits: per cell (one row of zeros at the end), per cell that can be refined, per eye point.
    BitMatrix known_, value_, need_, miss_, disagree_, active_;
    BitMatrix settled_, due_;  ///< by contribution: per cell, and of the cell at hand
};

}  // namespace viscache

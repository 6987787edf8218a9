#pragma once
// Level waves: Alg. 2 for all eye points and lights of a block at once, from the coarsest level to the
// finest.
//
// Differs (A29): AQVC goes pixel by pixel; here all values of a level are known before anything is refined.
// So there is no processing order, and almost no neighbour is unknown. The representative of a cell is the
// eye point nearest its centre. Per level:
//   1. Trace the unknown bits that the representatives want, sorted by light. With contributions, trace only
//      those that are due (contribution_levels.h).
//      An eye point takes the answers of its own rays, also for bits that a coarser cell had resolved.
//   2. Copy each answer to the finer cells of the same eye point.
//   3. For each cell: disagree = OR over four neighbours of known_n & (value_n ^ value) | ~known.
//   4. For each eye point: resolve the bits on which the cell agrees with its neighbours. The others are
//      needed at the next level.
// At the end, the remaining bits are those that eye points want but their representative does not. They are
// traced for the first of these eye points.
// Bits of kept rows are known from the start.
#include <vector>

#include "viscache/aqvc/columns.h"
#include "viscache/aqvc/contribution_levels.h"
#include "viscache/aqvc/kept_rows.h"
#include "viscache/aqvc/miss_tracer.h"
#include "viscache/aqvc/row_kernels.h"
#include "viscache/aqvc/tile_anchors.h"
#include "viscache/aqvc/tile_cells.h"

namespace viscache {

class Waves {
public:
    /// Answers the columns: sets bits of `visible` (eye points × columns, zeroed). Returns the number of
    /// rays. `kept` and `log` may be nullptr.
    uint64_t run(const TileAnchors& tile, const TileCells& tile_cells, const Columns& columns,
                 ContributionLevels& contribution_levels, MissTracer& tracer, KeptRows* kept,
                 BitMatrix& visible, Counters& counters, QueryLog* log);
    /// Rows of the cells after `run`.
    const BitMatrix& known() const { return known_; }
    const BitMatrix& value() const { return value_; }
    /// Eye points × columns that the finest level answered; empty if there is one level.
    const BitMatrix& finest() const { return finest_; }

private:
    uint64_t trace_level(size_t level, const EyeBlock& eyes, const Columns& columns, MissTracer& tracer);
    void adopt_own(size_t level, BitMatrix& visible, Counters& counters);
    void store_below(size_t level);
    void resolve_level(size_t level, BitMatrix& visible, Counters& counters);
    uint64_t finish(const EyeBlock& eyes, const Columns& columns, MissTracer& tracer, BitMatrix& visible,
                    Counters& counters);

    /// Runs `answer`, which resolves bits of an eye point from a cell, and notes them for the log.
    template <class Answer>
    auto noted(uint32_t eye, uint32_t cell, size_t level, Answer answer);
    void note(uint32_t eye, uint32_t cell, size_t level, std::span<const Word> bits);
    void write_log(const Columns& columns) const;

    RowPair row(uint32_t cell) const { return {known_.row(cell), value_.row(cell)}; }

    const RowKernels& kernels_ = row_kernels(active_isa());
    size_t eyes_ = 0, levels_ = 0, words_ = 0;
    const TileCells* cells_ = nullptr;
    ContributionLevels* contribution_levels_ = nullptr;
    const Columns* columns_ = nullptr;
    QueryLog* log_ = nullptr;
    // With a log: the eye point whose ray decided [cell][column]; bits of an eye point before `answer`; the
    // cell that answered [eye point][column]
    struct Answered {
        uint32_t cell = kNoCell;
        uint8_t level = 0;
    };
    std::vector<uint32_t> traced_by_;
    std::vector<Word> before_;
    std::vector<Answered> answered_;
    /// Rows of bits: per cell (with a row of zeros at the end), per cell that can be refined, or per eye
    /// point.
    BitMatrix known_, value_, need_, miss_, disagree_, active_, finest_;
    BitMatrix resolved_, due_;  ///< with contributions: per cell, and for the current cell
};

}  // namespace viscache

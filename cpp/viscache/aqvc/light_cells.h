#pragma once
// The light cells that a tile's own samples fall into, numbered: the columns of their bit rows.
//
// The pixels' samples differ, their light cells do not: R of Eq. 7 and 9 follows from the density at the far
// end. So samples of different eye points meet in the same column.
#include <array>
#include <vector>

#include "viscache/aqvc/columns.h"
#include "viscache/aqvc/tile_table.h"
#include "viscache/visibility/local_samples.h"

namespace viscache {

class LightCells {
public:
    static constexpr uint32_t kNoKey = 0xffffffffu;  ///< not finite, or no normal
    static constexpr uint32_t kFull = 0xfffffffeu;   ///< a new cell where there is no more room

    /// Forgets all; at most `limit` cells will get numbers.
    void clear(uint32_t limit);
    uint32_t count() const { return count_; }
    /// The column of every sample: cells are numbered in the order in which samples first touch them.
    void number(const LocalSamples& samples, const CellGrid& grid, const AqvcParameters& p,
                std::vector<uint32_t>& column, ClampCounts& clamps);

private:
    /// Cells across, up to which a resolution of directions has a table of its own.
    static constexpr uint32_t kDense = 256;

    void number_directions(const LocalSamples& samples, const CellGrid& grid, const AqvcParameters& p,
                           const std::vector<float>& density, std::vector<uint32_t>& column,
                           ClampCounts& clamps);
    void number_points(const LocalSamples& samples, const CellGrid& grid, const AqvcParameters& p,
                       const std::vector<float>& density, std::vector<uint32_t>& column, ClampCounts& clamps);
    uint32_t number_in(std::vector<uint32_t>& table, size_t at);
    uint32_t number_sparse(const Cell& cell);

    uint32_t limit_ = 0, count_ = 0;
    /// [R]: R × R columns + 1, row by row, 0 = none yet; empty: not met yet.
    std::array<std::vector<uint32_t>, kDense + 1> dense_;
    std::vector<size_t> used_;         ///< R whose table is not empty
    CellNumbers sparse_;               ///< all other cells
    std::vector<uint32_t> column_of_;  ///< of the sparse ones
    std::vector<double> u_, v_;
};

}  // namespace viscache

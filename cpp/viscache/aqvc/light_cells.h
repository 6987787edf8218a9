#pragma once
// Numbers the light cells of the samples of a tile. The cells are the columns of its bit rows.
//
// Pixels have different samples but share light cells, because R of Eq. 7 and 9 follows from the density at
// the far end. So samples of different eye points share columns.
#include <array>
#include <vector>

#include "viscache/aqvc/columns.h"
#include "viscache/aqvc/tile_table.h"
#include "viscache/visibility/local_samples.h"

namespace viscache {

class LightCells {
public:
    static constexpr uint32_t kNoKey = 0xffffffffu;  ///< the sample is not finite or has no normal
    static constexpr uint32_t kFull = 0xfffffffeu;   ///< the limit is reached; the cell gets no number

    /// Removes all cells. At most `limit` cells will get numbers.
    void clear(uint32_t limit);
    uint32_t count() const { return count_; }
    /// Finds the column of every sample. Cells are numbered in the order in which samples first use them.
    void number(const LocalSamples& samples, const CellGrid& grid, const AqvcParameters& p,
                std::vector<uint32_t>& column, ClampCounts& clamps);

private:
    /// Resolutions of directions up to this many cells across have a dense table.
    static constexpr uint32_t kDense = 256;

    void number_directions(const LocalSamples& samples, const CellGrid& grid, const AqvcParameters& p,
                           const std::vector<float>& density, std::vector<uint32_t>& column,
                           ClampCounts& clamps);
    void number_points(const LocalSamples& samples, const CellGrid& grid, const AqvcParameters& p,
                       const std::vector<float>& density, std::vector<uint32_t>& column, ClampCounts& clamps);
    uint32_t number_in(std::vector<uint32_t>& table, size_t at);
    uint32_t number_sparse(const Cell& cell);

    uint32_t limit_ = 0, count_ = 0;
    /// Indexed by R: R × R entries in rows, column + 1 or 0 for none. Empty if R is not in use.
    std::array<std::vector<uint32_t>, kDense + 1> dense_;
    std::vector<size_t> used_;         ///< R with a table in use
    CellNumbers sparse_;               ///< numbers of all other cells
    std::vector<uint32_t> column_of_;  ///< columns of the sparse cells
    std::vector<double> u_, v_;
};

}  // namespace viscache

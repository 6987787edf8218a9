#pragma once
// The cells that a tile's eye points make at every level of C_E: their numbers, representatives and
// neighbours. Light groups with equal levels share them.
#include <array>
#include <vector>

#include "viscache/aqvc/place_cells.h"
#include "viscache/aqvc/tile_table.h"

namespace viscache {

class TileCells {
public:
    /// `placer` has begun the tile.
    void make(const TileAnchors& tile, CellPlacer& placer, const std::vector<double>& levels);

    size_t size() const { return numbers_.size(); }
    size_t levels() const { return level_begin_.size() - 1; }
    /// Cells have numbers level by level; begin(levels()) is their count.
    uint32_t begin(size_t level) const { return level_begin_[level]; }
    /// Number of an eye point's cell; kNoCell where it bypasses the cache. One of a coarser level where the
    /// eye point's resolution did not change.
    uint32_t of(size_t level, size_t eye) const { return cell_[level * eyes_ + eye]; }
    /// The eye point that is asked for the cell.
    uint32_t representative(uint32_t cell) const { return representative_[cell].eye; }
    /// Of all cells but the finest; size() where no eye point made the neighbour.
    const std::array<uint32_t, 4>& neighbours(uint32_t cell) const { return neighbours_[cell]; }

    ClampCounts clamps;
    uint64_t nil_neighbours = 0;

private:
    struct Representative {
        uint32_t eye;
        bool coarser;      ///< stands for a coarser cell already
        double distance2;  ///< to the cell's centre
    };
    void number_level(const TileAnchors& tile, size_t level);
    void offer_representative(uint32_t cell, const Representative& candidate);
    void find_neighbours(const TileAnchors& tile, const std::vector<double>& levels);

    size_t eyes_ = 0;
    CellNumbers numbers_;
    std::vector<uint32_t> cell_;  ///< [level][eye point]
    std::vector<uint32_t> level_begin_{0};
    std::vector<Representative> representative_;
    std::vector<std::array<uint32_t, 4>> neighbours_;
    std::vector<uint8_t> stands_;  ///< eye points that represent a cell of a coarser level
    PlacedLevel placed_, above_;
};

}  // namespace viscache

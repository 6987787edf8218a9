#pragma once
// The cells of the eye points of a tile at every level of C_E: numbers, representatives and neighbours. Light
// groups with equal levels share them.
#include <array>
#include <vector>

#include "viscache/aqvc/place_cells.h"
#include "viscache/aqvc/tile_table.h"

namespace viscache {

class TileCells {
public:
    /// `placer` has begun this tile.
    void make(const TileAnchors& tile, CellPlacer& placer, const std::vector<double>& levels);

    size_t size() const { return numbers_.size(); }
    size_t levels() const { return level_begin_.size() - 1; }
    /// The first cell of a level; cells are numbered level by level. begin(levels()) is the number of cells.
    uint32_t begin(size_t level) const { return level_begin_[level]; }
    const Cell& cell(uint32_t number) const { return numbers_[number]; }
    /// The cell of an eye point, or kNoCell if it bypasses the cache. It is a cell of a coarser level if the
    /// resolution of the eye point did not change.
    uint32_t of(size_t level, size_t eye) const { return cell_[level * eyes_ + eye]; }
    /// The eye point whose ray is traced for the cell.
    uint32_t representative(uint32_t cell) const { return representative_[cell].eye; }
    /// Neighbours of a cell, for all levels but the finest; size() for a neighbour without eye points.
    const std::array<uint32_t, 4>& neighbours(uint32_t cell) const { return neighbours_[cell]; }

    ClampCounts clamps;
    uint64_t nil_neighbours = 0;

private:
    struct Representative {
        uint32_t eye;
        bool coarser;      ///< represents a coarser cell
        double distance2;  ///< distance to the centre of the cell
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
    std::vector<uint8_t> is_representative_;  ///< per eye point: it represents a cell of a coarser level
    PlacedLevel placed_, above_;
};

}  // namespace viscache

#include "viscache/aqvc/tile_cells.h"

namespace viscache {

void TileCells::make(const TileAnchors& tile, CellPlacer& placer, const std::vector<double>& levels) {
    eyes_ = tile.size();
    numbers_.clear();
    representative_.clear();
    level_begin_.assign(1, 0);
    cell_.assign(levels.size() * eyes_, kNoCell);
    is_representative_.assign(eyes_, 0);
    clamps = {};
    nil_neighbours = 0;
    for (size_t d = 0; d < levels.size(); ++d) {
        // The cells of the level before are compared with the new ones.
        std::swap(placed_, above_);
        placer.place(levels[d], placed_, clamps);
        number_level(tile, d);
        level_begin_.push_back(uint32_t(numbers_.size()));
        // Their rays are traced, whatever happens at finer levels.
        for (uint32_t c = level_begin_[d]; c < level_begin_[d + 1]; ++c)
            is_representative_[representative_[c].eye] = 1;
    }
    find_neighbours(tile, levels);
}

/// Numbers cells in the order in which eye points first use them. If the ladder resolution of an eye point
/// does not change, it keeps the cell of the coarser level.
void TileCells::number_level(const TileAnchors& tile, size_t level) {
    const PlacedLevel &p = placed_, &a = above_;
    // The number of the previous eye point, and which it was
    uint32_t last = kNoCell, before = 0;
    for (uint32_t i = 0; i < eyes_; ++i) {
        if (!tile.usable[i]) continue;
        uint32_t& number = cell_[level * eyes_ + i];
        if (level > 0 && p.slot[i] == a.slot[i] && p.x[i] == a.x[i] && p.y[i] == a.y[i] && p.z[i] == a.z[i]) {
            number = of(level - 1, i);
            continue;
        }
        // Neighbours along the Morton order often share their cell
        const int32_t bin = tile.anchor[i].bin;
        const bool same = last != kNoCell && p.slot[i] == p.slot[before] && p.x[i] == p.x[before] &&
                          p.y[i] == p.y[before] && p.z[i] == p.z[before] && bin == tile.anchor[before].bin;
        if (!same)
            last = numbers_.number(
                {bin, p.slot[i], floor_to_int(p.x[i]), floor_to_int(p.y[i]), floor_to_int(p.z[i])},
                uint32_t(level));
        number = last;
        before = i;
        offer_representative(number, {i, is_representative_[i] != 0, p.distance2[i]});
    }
}

/// Keeps the eye point nearest the centre. An eye point that represents a coarser cell takes precedence.
void TileCells::offer_representative(uint32_t cell, const Representative& candidate) {
    if (cell == representative_.size()) {
        representative_.push_back(candidate);
        return;
    }
    Representative& r = representative_[cell];
    // The ray of a coarser cell's representative is traced before this level and copied to this cell
    // (`store_below`). If the same eye point represents both, one ray serves both.
    if (candidate.coarser != r.coarser ? candidate.coarser : candidate.distance2 < r.distance2) r = candidate;
}

void TileCells::find_neighbours(const TileAnchors& tile, const std::vector<double>& levels) {
    // The number of the row that is always nil
    const uint32_t absent = uint32_t(numbers_.size());
    ClampCounts counted_already;
    // Neighbours at the finest level are never used.
    neighbours_.resize(level_begin_[levels.size() - 1]);
    for (size_t d = 0; d + 1 < levels.size(); ++d)
        for (uint32_t c = level_begin_[d]; c < level_begin_[d + 1]; ++c) {
            const uint32_t eye = representative_[c].eye;
            const Anchor& anchor = tile.anchor[eye];
            // Placed once more: only the representative's position inside the cell decides about neighbours.
            const PlacedCell placed = tile.cell(eye, levels[d], counted_already);
            for (size_t q = 0; q < 4; ++q) {
                const auto [dx, dy] = kNeighbourOffsets[q];
                uint32_t n = numbers_.find(tile.grid->neighbour(anchor, placed, dx, dy), uint32_t(d));
                // Where the tangent plane leads past the cells of the tile, the neighbour at the same height
                // is tried.
                if (n == kNoCell)
                    n = numbers_.find(tile.grid->neighbour(anchor, placed, dx, dy, true), uint32_t(d));
                neighbours_[c][q] = n == kNoCell ? absent : n;
                nil_neighbours += n == kNoCell;
            }
        }
}

}  // namespace viscache

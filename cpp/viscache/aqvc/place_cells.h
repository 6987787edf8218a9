#pragma once
// Cells of a tile's eye points for one C_E, sixteen eye points at a time: the same numbers as
// TileAnchors::cell gives one by one. Keys were half of the frame where few lights are shared.
#include <cstdint>
#include <vector>

#include "viscache/aqvc/tile_anchors.h"
#include "viscache/math/isa.h"

namespace viscache {

/// Where eye points lie in the grids of one C_E; entries of unusable eye points mean nothing.
struct PlacedLevel {
    std::vector<int32_t> slot;      ///< rung of the ladder, as in Cell
    std::vector<double> x, y, z;    ///< the cell: integers
    std::vector<double> distance2;  ///< to its centre, as distance2_to_center
    void resize(size_t n) {
        slot.resize(n);
        for (auto* v : {&x, &y, &z, &distance2}) v->resize(n);
    }
};

class CellPlacer {
public:
    /// Learns the tile, which must outlive the calls of `place`.
    void begin(const TileAnchors& tile);
    /// `out` holds room for whole groups of sixteen.
    void place(double c_e, PlacedLevel& out, ClampCounts& clamps, Isa isa = active_isa());

private:
    void find_rungs(double c_e, size_t first, size_t last, int32_t* slot, ClampCounts& clamps);
    void place_singly(double c_e, size_t first, size_t last, PlacedLevel& out, ClampCounts& clamps) const;

    const TileAnchors* tile_ = nullptr;
    std::vector<double> x_, y_, z_;  ///< of the anchors
    std::vector<double> root_;       ///< 2 B_R √D_e: R of Eq. 7 is this over C_E
    double scale_[16] = {};          ///< cells per unit length of the sixteen at hand
    size_t rung_ = 0;                ///< of the eye point before: neighbours mostly share it
};

}  // namespace viscache

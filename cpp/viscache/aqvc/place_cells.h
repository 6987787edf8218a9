#pragma once
// Cells of the eye points of a tile for one C_E, 16 eye points at a time. The results equal those of
// TileAnchors::cell.
#include <cstdint>
#include <vector>

#include "viscache/aqvc/tile_anchors.h"
#include "viscache/math/isa.h"

namespace viscache {

/// Cells of eye points in the grids of one C_E. Entries of unusable eye points have no meaning.
struct PlacedLevel {
    std::vector<int32_t> slot;      ///< rung of the ladder, as in Cell
    std::vector<double> x, y, z;    ///< integer coordinates of the cell
    std::vector<double> distance2;  ///< distance to the centre, as by distance2_to_center
    void resize(size_t n) {
        slot.resize(n);
        for (auto* v : {&x, &y, &z, &distance2}) v->resize(n);
    }
};

class CellPlacer {
public:
    /// Reads the tile, which must outlive the calls of `place`.
    void begin(const TileAnchors& tile);
    /// Places all eye points; `out` has room for whole groups of 16.
    void place(double c_e, PlacedLevel& out, ClampCounts& clamps, Isa isa = active_isa());

private:
    void find_rungs(double c_e, size_t first, size_t last, int32_t* slot, ClampCounts& clamps);
    void place_singly(double c_e, size_t first, size_t last, PlacedLevel& out, ClampCounts& clamps) const;

    const TileAnchors* tile_ = nullptr;
    std::vector<double> x_, y_, z_;  ///< coordinates of the anchors
    std::vector<double> root_;       ///< 2 B_R √D_e, which is C_E times R of Eq. 7
    double scale_[16] = {};          ///< cells per unit length of the current 16
    size_t rung_ = 0;                ///< rung of the previous eye point; neighbours often share it
};

}  // namespace viscache

#pragma once
// What a tile's eye points need for their cells of any light group: computed once per tile.
#include <array>
#include <map>
#include <vector>

#include "viscache/aqvc/cluster_key.h"
#include "viscache/aqvc/tile_table.h"
#include "viscache/visibility/oracle.h"
#include "viscache/visibility/shadow_ray.h"

namespace viscache {

/// Two numbers in [−1/2, 1/2), in 2^32 steps, from the bits of a point.
inline std::array<double, 2> jitter_of(Vec3 p, uint32_t seed) {
    uint64_t h = seed;
    for (float v : {p.x, p.y, p.z}) h = murmur64(h + uint32_t(float_bits(v)) + 0x9e3779b97f4a7c15ull);
    return {double(h >> 32) * 0x1p-32 - 0.5, double(h & 0xffffffffu) * 0x1p-32 - 0.5};
}

struct TileAnchors {
    const EyeBlock* eyes = nullptr;
    const CellGrid* grid = nullptr;
    std::vector<Anchor> anchor;
    std::vector<uint8_t> usable;  ///< has a position and a normal; other eye points bypass the cache

    void make(const EyeBlock& block, const CellGrid& cells) {
        eyes = &block, grid = &cells;
        occupied_.clear();
        anchor.resize(block.size()), usable.resize(block.size());
        for (size_t i = 0; i < block.size(); ++i) {
            anchor[i] = cells.anchor(block.position[i], block.normal[i]);
            usable[i] = anchor[i].valid && is_traceable(block.position[i]) && is_traceable(block.origin[i]);
        }
    }
    size_t size() const { return anchor.size(); }
    /// Cell of an eye point for one C_E by Eq. 7; moved at random where `allow_jitter` was called for it.
    PlacedCell cell(size_t eye, double c_e, ClampCounts& clamps) const {
        const PlacedCell placed = cell_of_point(eye, c_e, clamps);
        const auto occupied = occupied_.find(c_e);
        return occupied == occupied_.end() ? placed : jittered(eye, placed, occupied->second);
    }
    /// From now on points of these C_E are moved before they are quantized.
    void allow_jitter(const std::vector<double>& levels, uint32_t seed) {
        seed_ = seed;
        ClampCounts uncounted;
        for (double c_e : levels) {
            if (occupied_.count(c_e)) continue;
            CellNumbers cells;
            cells.clear();
            for (size_t i = 0; i < size(); ++i)
                if (usable[i]) cells.number(cell_of_point(i, c_e, uncounted).cell, 0);
            occupied_.emplace(c_e, std::move(cells));
        }
    }

    bool jitters(double c_e) const { return occupied_.count(c_e) != 0; }

private:
    PlacedCell cell_of_point(size_t eye, double c_e, ClampCounts& clamps) const {
        const double r = resolution_eye(eyes->density[eye], c_e, grid->radius());
        return grid->cell(anchor[eye], grid->ladder.rung(r, clamps));
    }
    /// The cell of the point moved along its tangent plane by up to half a cell, unless no eye point of the
    /// tile lies there: then it left the surface or its normals' bin. Tangent coordinates stay the point's
    /// own, so that the representative is still the one nearest the centre.
    PlacedCell jittered(size_t eye, const PlacedCell& placed, const CellNumbers& occupied) const {
        const auto [dx, dy] = jitter_of(eyes->position[eye], seed_);
        const Anchor& a = anchor[eye];
        PlacedCell moved = placed;
        moved.fz = placed.fz - (dx * a.slope_x + dy * a.slope_y);
        moved.cell.x = floor_to_int(placed.fx + dx), moved.cell.y = floor_to_int(placed.fy + dy);
        moved.cell.z = floor_to_int(moved.fz);
        return occupied.find(moved.cell, 0) == kNoCell ? placed : moved;
    }
    std::map<double, CellNumbers> occupied_;  ///< cells of points as they are, by C_E
    uint32_t seed_ = 0;
};

}  // namespace viscache

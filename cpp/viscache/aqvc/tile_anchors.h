#pragma once
// Data of the eye points of a tile from which their cells follow for any light group; computed once per tile.
#include <vector>

#include "viscache/aqvc/cluster_key.h"
#include "viscache/visibility/oracle.h"
#include "viscache/visibility/shadow_ray.h"

namespace viscache {

struct TileAnchors {
    const EyeBlock* eyes = nullptr;
    const CellGrid* grid = nullptr;
    std::vector<Anchor> anchor;
    std::vector<uint8_t> usable;  ///< finite position and a normal; other eye points bypass the cache

    void make(const EyeBlock& block, const CellGrid& cells) {
        eyes = &block;
        grid = &cells;
        anchor.resize(block.size());
        usable.resize(block.size());
        for (size_t i = 0; i < block.size(); ++i) {
            anchor[i] = cells.anchor(block.position[i], block.normal[i]);
            // Both positions matter: cells follow the surface point, rays start at the offset one.
            usable[i] = anchor[i].valid && is_traceable(block.position[i]) && is_traceable(block.origin[i]);
        }
    }
    size_t size() const { return anchor.size(); }
    /// The cell of an eye point for one C_E by Eq. 7.
    PlacedCell cell(size_t eye, double c_e, ClampCounts& clamps) const {
        const double r = resolution_eye(eyes->density[eye], c_e, grid->radius());
        return grid->cell(anchor[eye], grid->ladder.rung(r, clamps));
    }
};

}  // namespace viscache

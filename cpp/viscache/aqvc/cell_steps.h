#pragma once
// The cells of each eye point of a tile, from coarse to fine. Alg. 2 walks through them where every cell has
// a row of bits.
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "viscache/aqvc/tile_anchors.h"
#include "viscache/aqvc/tile_table.h"

namespace viscache {

class CellSteps {
public:
    /// A cell of an eye point that differs from the cell of the coarser level.
    struct Step {
        uint32_t cell, level;
        float distance2;  ///< from the eye point to the centre of the cell
        std::array<uint32_t, 4> neighbours;
    };

    /// Numbers the cells of all levels. A neighbour that holds no eye point of the tile always stays nil; its
    /// number is size().
    void make(const TileAnchors& tile, const std::vector<double>& levels, ClampCounts& clamps) {
        numbers_.clear();
        steps_.clear();
        begin_.clear();
        std::vector<PlacedCell> placed;
        for (size_t i = 0; i < tile.size(); ++i) {
            begin_.push_back(uint32_t(steps_.size()));
            if (!tile.usable[i]) continue;
            for (size_t d = 0; d < levels.size(); ++d) {
                const PlacedCell p = tile.cell(i, levels[d], clamps);
                // The ladder of resolutions is coarse: halving C_E may lead to the same cell, whose answer is
                // known already (Alg. 2).
                if (d > 0 && p.cell == placed.back().cell) continue;
                const float distance2 = float(distance2_to_center(p));
                steps_.push_back({numbers_.number(p.cell, 0), uint32_t(d), distance2, {}});
                placed.push_back(p);
            }
        }
        begin_.push_back(uint32_t(steps_.size()));
        // Neighbours can be found only when all cells have numbers. The finest cell of a point needs none:
        // there, Alg. 2 accepts the bit whatever its neighbours say.
        for (size_t i = 0; i < tile.size(); ++i)
            for (size_t s = begin_[i]; s + 1 < begin_[i + 1]; ++s)
                for (size_t q = 0; q < 4; ++q) {
                    const auto [dx, dy] = kNeighbourOffsets[q];
                    const uint32_t n =
                        numbers_.find(tile.grid->neighbour(tile.anchor[i], placed[s], dx, dy), 0);
                    // size() is the number of a row that always stays nil, and nil counts as agreement.
                    steps_[s].neighbours[q] = n == kNoCell ? uint32_t(numbers_.size()) : n;
                }
    }
    size_t size() const { return numbers_.size(); }
    /// Steps of an eye point; empty if it bypasses the cache.
    std::span<const Step> of(size_t eye) const {
        return {steps_.data() + begin_[eye], steps_.data() + begin_[eye + 1]};
    }

private:
    CellNumbers numbers_;
    std::vector<Step> steps_;
    std::vector<uint32_t> begin_;  ///< per eye point, and the end
};

}  // namespace viscache

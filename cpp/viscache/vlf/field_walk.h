#pragma once
// Walks a ray through the lists of one direction: tiles, then leaves, near to far.
#include <span>

#include "viscache/vlf/subfield.h"
#include "viscache/vlf/tile_walk.h"

namespace viscache {

/// Totals of what rays visited.
struct FieldSteps {
    uint64_t tiles = 0, leaves = 0, tests = 0;
};

/// A hit is certainly the nearest if it lies before the end of a leaf by this distance in the unit ball. At
/// grazing angles the error of a hit is smaller than the slack of a tile.
constexpr double kHitSlack = 1e-5;

/// Calls limit = leaf(ids, limit) for the leaves along a ray in one tile of one layer, until a hit is nearer
/// than the next leaf by `slack`. Returns the limit.
template <class Layer, class Leaf>
double walk_tile(const Layer& layer, size_t tile, LeafWalk how, const CanonicalRay& ray, double in,
                 double out, double slack, double limit, FieldSteps* steps, Leaf leaf) {
    const TileBsp bsp = layer.bsp(tile);
    if (bsp.leaves == 0) return limit;
    // Depths at which the ray enters and leaves the tile
    const double g = ray.g[2], z_in = ray.q[2] + in * g, z_out = ray.q[2] + out * g;
    const float low = float(std::min(z_in, z_out)), high = float(std::max(z_in, z_out));
    const auto range = layer.occupied(tile);
    // Nothing of the tile lies at these depths: the ray passes in front of it or behind it.
    if (high + kDepthSlack < range.z0 || low - kDepthSlack > range.z1) return limit;
    const bool upwards = g >= 0;
    const auto visit = [&](int l) {
        const std::span<const uint32_t> ids = layer.leaf(tile, l);
        if (steps) {
            ++steps->leaves;
            steps->tests += ids.size();
        }
        limit = leaf(ids, limit);
        // Outermost leaves also hold what lies beyond them
        const bool last = l == (upwards ? bsp.leaves - 1 : 0);
        // Where the ray leaves the leaf, in t. A hit before this point is nearer than everything in later
        // leaves; triangles that straddle leaves are listed in each, so a hit beyond it proves nothing yet.
        const double end = last || g == 0 ? out : (bsp.border(l + upwards) - ray.q[2]) / g;
        return limit + slack <= std::min(end, out);
    };
    if (how == LeafWalk::kLinear)
        walk_leaves(bsp, low, high, upwards, visit);
    else
        walk_leaves_by_stack(bsp, low, high, upwards, visit);
    return limit;
}

/// The same along all tiles and in all layers of a direction. A negative limit ends the walk.
template <class Layer, class Leaf>
void walk_field(std::span<const Layer* const> layers, const CanonicalRay& ray, int n_tiles, LeafWalk how,
                double limit, FieldSteps* steps, Leaf leaf) {
    // From the unit ball to t
    const double slack = kHitSlack / ray.length;
    walk_tiles(ray, n_tiles, [&](int column, int row, double in, double out) {
        if (steps) ++steps->tiles;
        // All layers of a tile are searched before the next tile, since a hit in any of them may be the
        // nearest.
        for (const Layer* layer : layers) {
            if (!layer->rect.holds(column, row)) continue;
            const size_t tile = layer->rect.index(column, row);
            limit = walk_tile(*layer, tile, how, ray, in, out, slack, limit, steps, leaf);
            if (limit < 0) return true;
        }
        // A hit before the tile's end is the nearest of all.
        return limit + slack <= out;
    });
}

}  // namespace viscache

#pragma once
// Divides the polygons of a tile along its depth.
#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

namespace viscache {

/// Where a tile is divided.
enum class DepthSplit {
    kUniform,  ///< 2^depth equal slabs
    kObject,   ///< at medians of the depths of the polygons
};
/// How a ray finds its leaves.
enum class LeafWalk {
    kLinear,  ///< from the first leaf to the last, by index
    kStack,   ///< by splitting the segment at the planes, near half first
};

constexpr int kMostBspDepthOfTile = 12;

/// Depth of a tile with `count` polygons. It has as many halvings as leave `leaf_target` polygons per leaf
/// of an evenly filled tile, at most `depth`. A target of 0 always gives `depth`.
// Differs (V4): the paper uses one depth for all tiles; at 5, 513 subfields of 128² tiles would take 1 GB for
// offsets.
inline int tile_depth(size_t count, int depth, int leaf_target) {
    if (leaf_target == 0) return count ? depth : 0;
    int d = 0;
    // Each halving halves the polygons, if depths are evenly distributed and none straddles.
    while (d < depth && count > size_t(leaf_target) << d) ++d;
    return d;
}

/// [VLF Sec. 4] The 1D partition of one tile. The leaves are in a plain array, ordered by depth, so that a
/// depth gives its leaf directly.
// Differs (V7): "median split" and lookup by t exclude each other; slabs are equal unless kObject is
// requested.
struct TileBsp {
    float z0 = -1, z1 = 1;           ///< depth range
    int leaves = 1;                  ///< a power of two
    const float* borders = nullptr;  ///< for kObject: [l] is the start of leaf l, for l >= 1

    /// Leaf of a depth; the outermost leaf for depths beyond the range. Never decreases with z, despite
    /// rounding.
    int leaf_of(float z) const {
        // A depth on a border belongs to the leaf that starts there.
        if (borders) return int(std::upper_bound(borders + 1, borders + leaves, z) - borders) - 1;
        // Clamped before the conversion, as in TileGrid::tile_of.
        const float place = (z - z0) * (float(leaves) / (z1 - z0));
        return place > 0 ? std::min(leaves - 1, int(std::min(place, float(leaves)))) : 0;
    }
    /// Start of leaf l; l = `leaves` gives the end of the last one.
    float border(int l) const {
        // Exact at both ends, where the quotient need not be.
        if (l == 0) return z0;
        if (l == leaves) return z1;
        return borders ? borders[l] : z0 + (z1 - z0) * (float(l) / float(leaves));
    }
};

/// Bound of the rounding error of a depth when its leaf is computed.
constexpr float kDepthSlack = 1e-6f;

/// Calls visit(leaf) for the leaves that overlap depths [low, high], upwards or downwards, until it returns
/// true. Returns whether it did.
template <class Visit>
bool walk_leaves(const TileBsp& bsp, float low, float high, bool upwards, Visit visit) {
    // Widened, so that rounding of the ray's depths skips no leaf.
    const int first = bsp.leaf_of(low - kDepthSlack), last = bsp.leaf_of(high + kDepthSlack);
    if (upwards) {
        for (int l = first; l <= last; ++l)
            if (visit(l)) return true;
    } else {
        for (int l = last; l >= first; --l)
            if (visit(l)) return true;
    }
    return false;
}

/// The same with the other method of the paper: the segment is split at the planes of the tree, and a stack
/// keeps the far halves.
template <class Visit>
bool walk_leaves_by_stack(const TileBsp& bsp, float low, float high, bool upwards, Visit visit) {
    struct Node {
        int first, count;
    };
    // One far half per halving at most
    Node stack[kMostBspDepthOfTile + 1];
    int entries = 0;
    // A node is a run of leaves: the tree is implicit, with plane k between leaves k − 1 and k.
    Node node{0, bsp.leaves};
    low -= kDepthSlack;
    high += kDepthSlack;
    for (;;) {
        while (node.count > 1) {
            const int half = node.count / 2;
            const Node below{node.first, half}, above{node.first + half, half};
            const float plane = bsp.border(above.first);
            if (high < plane) {
                node = below;
            } else if (low > plane) {
                node = above;
            } else {
                // The segment meets both halves: the far one waits.
                stack[entries++] = upwards ? above : below;
                node = upwards ? below : above;
            }
        }
        if (visit(node.first)) return true;
        if (entries == 0) return false;
        node = stack[--entries];
    }
}

/// One polygon of a tile.
struct TileEntry {
    uint32_t id;
    float low, high;  ///< depth range inside the tile
};

/// Borders of leaves at the medians of the middle depths of the entries; [0] is not used.
inline void object_borders(std::span<const TileEntry> entries, int leaves, std::vector<float>& middles,
                           float* borders) {
    middles.clear();
    for (const TileEntry& e : entries) middles.push_back(0.5f * (e.low + e.high));
    std::sort(middles.begin(), middles.end());
    borders[0] = 0;
    // Halfway between the two middle depths around each quantile
    for (int l = 1; l < leaves; ++l) {
        const size_t k = std::min(middles.size() - 1, middles.size() * size_t(l) / size_t(leaves));
        borders[l] = k ? 0.5f * (middles[k - 1] + middles[k]) : middles[0];
    }
}

}  // namespace viscache

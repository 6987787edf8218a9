#pragma once
// Divides all pairs of points into tiles. The points of a group are divided into blocks; a tile is a pair of
// blocks.
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace viscache {

/// Points first … last − 1, all of one group.
struct PointBlock {
    size_t first = 0, last = 0, group = 0;

    size_t size() const { return last - first; }
};

/// All pairs of two blocks, or the pairs i < j of one block.
struct PairTile {
    size_t a = 0, b = 0;
    size_t group_pair = 0;
    int64_t pairs = 0;
};

/// A fixed numbering of tiles, ordered by pairs of groups. It depends only on the groups and the block size.
struct PairTiles {
    /// `group` must not decrease. The blocks of a group differ in size by at most one point.
    PairTiles(std::span<const int32_t> group, size_t n_groups, size_t max_points);

    std::vector<PointBlock> blocks;
    std::vector<PairTile> tiles;
};

}  // namespace viscache

#pragma once
// One parallel subfield: the tiles of one direction and the triangles each of them lists.
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "viscache/vlf/rasterize.h"
#include "viscache/vlf/tile_bsp.h"

namespace viscache {

/// Of every subfield of a field.
struct SubfieldShape {
    TileGrid grid;
    int bsp_depth = 0;    ///< most halvings of a tile's depth
    int leaf_target = 4;  ///< see tile_depth
    DepthSplit split = DepthSplit::kUniform;
    bool tile_ranges = true;  ///< depth range per tile, else [−1, 1] for all
};

/// Tiles [x, x + width) × [y, y + height) of the grid.
struct TileRect {
    int x = 0, y = 0, width = 0, height = 0;
    size_t size() const { return size_t(width) * size_t(height); }
    bool holds(int column, int row) const {
        return column >= x && column < x + width && row >= y && row < y + height;
    }
    size_t index(int column, int row) const { return size_t(row - y) * size_t(width) + size_t(column - x); }
};

/// Lists in compressed rows: tile → leaves → triangles. A tile without triangles has no leaf.
struct Subfield {
    struct Range {
        float z0, z1;
    };
    TileRect rect;
    std::vector<uint32_t> first_leaf;  ///< (tiles + 1)
    std::vector<uint32_t> first_id;    ///< (leaves + 1)
    std::vector<uint32_t> ids;         ///< ascending in a leaf
    std::vector<Range> ranges;         ///< (tiles), or none
    std::vector<float> borders;        ///< (leaves) for split at medians, or none

    size_t tiles() const { return rect.size(); }
    /// Empty when leaves is 0.
    TileBsp bsp(size_t tile) const {
        TileBsp b;
        b.leaves = int(first_leaf[tile + 1] - first_leaf[tile]);
        if (!ranges.empty()) b.z0 = ranges[tile].z0, b.z1 = ranges[tile].z1;
        if (!borders.empty() && b.leaves > 1) b.borders = borders.data() + first_leaf[tile];
        return b;
    }
    /// Depths at which there is something.
    Range occupied(size_t tile) const { return ranges.empty() ? Range{-1, 1} : ranges[tile]; }
    std::span<const uint32_t> leaf(size_t tile, int l) const {
        const uint32_t at = first_leaf[tile] + uint32_t(l);
        return {ids.data() + first_id[at], ids.data() + first_id[at + 1]};
    }
    uint64_t bytes() const {
        return sizeof(uint32_t) * (first_leaf.size() + first_id.size() + ids.size()) +
               sizeof(Range) * ranges.size() + sizeof(float) * borders.size();
    }
};

/// Builds subfields one after another; keeps its buffers.
class SubfieldBuilder {
public:
    explicit SubfieldBuilder(const SubfieldShape& shape) : shape_(shape) {}
    /// Of triangles in the unit ball; triangle i is listed as `ids[i]`, or as i without ids (ascending).
    /// Covers the whole grid, or with `tight` the tiles that are touched. Throws std::length_error for 2^32
    /// entries or more.
    Subfield build(std::span<const FlatTriangle> triangles, std::span<const uint32_t> ids,
                   const Frame3& frame, bool tight = false);

private:
    struct Touch {
        uint32_t tile_x, tile_y;
        TileEntry entry;
    };
    void rasterize(std::span<const FlatTriangle> triangles, std::span<const uint32_t> ids,
                   const Frame3& frame);
    TileRect touched_rect() const;
    void sort_by_tile(const TileRect& rect);
    void add_tile(std::span<const TileEntry> entries, Subfield& made);

    SubfieldShape shape_;
    std::vector<Touch> touches_;
    std::vector<size_t> first_;  ///< (tiles + 1) into sorted_
    std::vector<TileEntry> sorted_;
    std::vector<uint32_t> counts_, first_id_, ids_;
    std::vector<float> borders_, middles_;
};

}  // namespace viscache

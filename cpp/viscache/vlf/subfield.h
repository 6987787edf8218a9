#pragma once
// One parallel subfield: the tiles of one direction, with the triangles that each of them lists.
#include <cstdint>
#include <span>
#include <vector>

#include "viscache/vlf/rasterize.h"
#include "viscache/vlf/tile_bsp.h"

namespace viscache {

/// Settings shared by all subfields of a field.
struct SubfieldShape {
    TileGrid grid;
    int bsp_depth = 0;    ///< maximum number of halvings of a tile's depth
    int leaf_target = 4;  ///< see tile_depth
    DepthSplit split = DepthSplit::kUniform;
    bool tile_ranges = true;  ///< depth range per tile; false: [−1, 1] for all
    bool fit_box = false;     ///< tiles cover the bounding box of the triangles across the beams; false: the
                              ///< square around the ball
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

/// Lists in compressed rows, tile by tile: the end of each leaf, then the triangles of all leaves, one after
/// the other. The data of a tile is in two places of memory instead of five, because an incoherent ray
/// mostly waits for memory.
class Subfield {
public:
    struct Range {
        float z0, z1;
    };
    TileRect rect;
    TileFit fit;

    size_t tiles() const { return rect.size(); }
    /// `leaves` is 0 for an empty tile.
    TileBsp bsp(size_t tile) const {
        const Tile& t = tiles_[tile];
        const float* borders = cut_at_borders(t) ? borders_.data() + pool_[t.first] : nullptr;
        return {t.z0, t.z1, int(t.leaves), borders};
    }
    /// Depth range that is not empty.
    Range occupied(size_t tile) const { return {tiles_[tile].z0, tiles_[tile].z1}; }
    /// Triangles of a leaf, ascending.
    std::span<const uint32_t> leaf(size_t tile, int l) const {
        const Tile& t = tiles_[tile];
        // Skips the index of borders
        const uint32_t* ends = pool_.data() + t.first + cut_at_borders(t);
        const uint32_t* ids = ends + t.leaves;
        return {ids + (l ? ends[l - 1] : 0), ids + ends[l]};
    }
    uint64_t bytes() const {
        return sizeof(Tile) * tiles_.size() + sizeof(uint32_t) * pool_.size() +
               sizeof(float) * borders_.size();
    }

private:
    friend class SubfieldBuilder;
    // 16 bytes: four tiles per cache line
    struct Tile {
        uint32_t first = 0;  ///< start in the pool
        uint32_t leaves = 0;
        float z0 = -1, z1 = 1;
    };
    bool cut_at_borders(const Tile& t) const { return !borders_.empty() && t.leaves > 1; }

    std::vector<Tile> tiles_;
    std::vector<uint32_t> pool_;  ///< per tile: index of its borders, if any; ends of leaves; triangles
    std::vector<float> borders_;  ///< for tiles split at medians: [l] is the start of leaf l
};

/// Builds subfields one after another and reuses its buffers.
class SubfieldBuilder {
public:
    explicit SubfieldBuilder(const SubfieldShape& shape) : shape_(shape) {}
    /// Builds the subfield of triangles in the unit ball. Triangle i is listed as `ids[i]`, or as i without
    /// ids; ids are ascending. Covers the whole grid, or with `tight` only the touched tiles. Throws
    /// std::length_error for 2^32 entries or more.
    Subfield build(std::span<const FlatTriangle> triangles, std::span<const uint32_t> ids,
                   const Frame3& frame, bool tight = false);
    /// Bytes of the buffers, which live as long as the builder.
    uint64_t bytes() const {
        return sizeof(Touch) * touches_.capacity() + sizeof(size_t) * first_.capacity() +
               sizeof(TileEntry) * sorted_.capacity() + sizeof(uint32_t) * pool_.capacity() +
               sizeof(float) * (borders_.capacity() + middles_.capacity());
    }

private:
    struct Touch {
        uint32_t tile_x, tile_y;
        TileEntry entry;
    };
    void rasterize(std::span<const FlatTriangle> triangles, std::span<const uint32_t> ids,
                   const Frame3& frame, const TileFit& fit);
    TileRect touched_rect() const;
    void sort_by_tile(const TileRect& rect);
    Subfield::Tile add_tile(std::span<const TileEntry> entries);
    void require_room(size_t words) const;

    SubfieldShape shape_;
    std::vector<Touch> touches_;
    std::vector<size_t> first_;  ///< (tiles + 1) offsets into sorted_
    std::vector<TileEntry> sorted_;
    std::vector<uint32_t> pool_;
    std::vector<float> borders_, middles_;
};

}  // namespace viscache

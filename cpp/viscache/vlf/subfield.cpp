#include "viscache/vlf/subfield.h"

#include <limits>
#include <stdexcept>

namespace viscache {

void SubfieldBuilder::rasterize(std::span<const FlatTriangle> triangles, std::span<const uint32_t> ids,
                                const Frame3& frame) {
    touches_.clear();
    for (uint32_t i = 0; i < triangles.size(); ++i) {
        const uint32_t id = ids.empty() ? i : ids[i];
        cover_tiles(projected(triangles[i], frame), shape_.grid, [&](int x, int y, float low, float high) {
            touches_.push_back({uint32_t(x), uint32_t(y), {id, low, high}});
        });
    }
    if (touches_.size() >= std::numeric_limits<uint32_t>::max())
        throw std::length_error("a subfield lists at most 2^32 - 2 triangles, n_tiles is too large");
}

TileRect SubfieldBuilder::touched_rect() const {
    if (touches_.empty()) return {};
    uint32_t x0 = touches_[0].tile_x, x1 = x0, y0 = touches_[0].tile_y, y1 = y0;
    for (const Touch& t : touches_) {
        x0 = std::min(x0, t.tile_x), x1 = std::max(x1, t.tile_x);
        y0 = std::min(y0, t.tile_y), y1 = std::max(y1, t.tile_y);
    }
    return {int(x0), int(y0), int(x1 - x0 + 1), int(y1 - y0 + 1)};
}

/// Counting sort; keeps the order of triangles.
void SubfieldBuilder::sort_by_tile(const TileRect& rect) {
    first_.assign(rect.size() + 1, 0);
    const auto tile = [&](const Touch& t) { return rect.index(int(t.tile_x), int(t.tile_y)); };
    for (const Touch& t : touches_) ++first_[tile(t) + 1];
    for (size_t i = 0; i < rect.size(); ++i) first_[i + 1] += first_[i];
    sorted_.resize(touches_.size());
    for (const Touch& t : touches_) sorted_[first_[tile(t)]++] = t.entry;
    for (size_t i = rect.size(); i > 0; --i) first_[i] = first_[i - 1];
    first_[0] = 0;
}

/// Appends the leaves of one tile.
void SubfieldBuilder::add_tile(std::span<const TileEntry> entries, Subfield& made) {
    if (entries.empty()) return;
    TileBsp bsp;
    if (shape_.tile_ranges) {
        bsp.z0 = kInfinity, bsp.z1 = -kInfinity;
        for (const TileEntry& e : entries)
            bsp.z0 = std::min(bsp.z0, e.low), bsp.z1 = std::max(bsp.z1, e.high);
        made.ranges.back() = {bsp.z0, bsp.z1};
    }
    bsp.leaves = 1 << tile_depth(entries.size(), shape_.bsp_depth, shape_.leaf_target);
    if (shape_.split == DepthSplit::kObject && shape_.bsp_depth > 0) {
        borders_.resize(borders_.size() + size_t(bsp.leaves));
        float* borders = borders_.data() + borders_.size() - bsp.leaves;
        object_borders(entries, bsp.leaves, middles_, borders);
        if (bsp.leaves > 1) bsp.borders = borders;
    }
    counts_.assign(size_t(bsp.leaves) + 1, 0);
    for (const TileEntry& e : entries)
        for (int l = bsp.leaf_of(e.low), last = bsp.leaf_of(e.high); l <= last; ++l) ++counts_[size_t(l) + 1];
    const size_t start = ids_.size();
    for (int l = 0; l < bsp.leaves; ++l) {
        first_id_.push_back(uint32_t(start + counts_[size_t(l)]));
        counts_[size_t(l) + 1] += counts_[size_t(l)];
    }
    if (start + counts_.back() >= std::numeric_limits<uint32_t>::max())
        throw std::length_error("a subfield lists at most 2^32 - 2 triangles, n_tiles is too large");
    ids_.resize(start + counts_.back());
    for (const TileEntry& e : entries)
        for (int l = bsp.leaf_of(e.low), last = bsp.leaf_of(e.high); l <= last; ++l)
            ids_[start + counts_[size_t(l)]++] = e.id;
}

Subfield SubfieldBuilder::build(std::span<const FlatTriangle> triangles, std::span<const uint32_t> ids,
                                const Frame3& frame, bool tight) {
    rasterize(triangles, ids, frame);
    Subfield made;
    made.rect = tight ? touched_rect() : TileRect{0, 0, shape_.grid.n, shape_.grid.n};
    sort_by_tile(made.rect);
    first_id_.clear(), ids_.clear(), borders_.clear();
    made.first_leaf.reserve(made.tiles() + 1);
    if (shape_.tile_ranges) made.ranges.reserve(made.tiles());
    for (size_t tile = 0; tile < made.tiles(); ++tile) {
        made.first_leaf.push_back(uint32_t(first_id_.size()));
        if (shape_.tile_ranges) made.ranges.push_back({0, 0});
        add_tile(std::span(sorted_).subspan(first_[tile], first_[tile + 1] - first_[tile]), made);
    }
    made.first_leaf.push_back(uint32_t(first_id_.size()));
    first_id_.push_back(uint32_t(ids_.size()));
    made.first_id.assign(first_id_.begin(), first_id_.end());
    made.ids.assign(ids_.begin(), ids_.end());
    made.borders.assign(borders_.begin(), borders_.end());
    return made;
}

}  // namespace viscache

#include "viscache/vlf/subfield.h"

#include <algorithm>
#include <limits>
#include <stdexcept>

namespace viscache {

namespace {

/// Largest scale of a box. The dilation of coverage is scaled as well.
/// A scene that is flat across the beams has no width to divide by.
constexpr float kMostScale = 64;

/// Centre and scale that map [low, high], widened by `margin`, to [−1, 1].
void fit_side(float low, float high, float margin, float& centre, float& scale) {
    // The margin keeps the corners, dilated by the slack, on the tiles.
    centre = 0.5f * (low + high);
    scale = std::min(kMostScale, 1 / std::max(0.5f * (high - low) + margin, 1e-6f));
}

TileFit box_of(std::span<const FlatTriangle> triangles, const Frame3& frame, float slack) {
    TileFit fit;
    if (triangles.empty()) return fit;
    float low[2] = {kInfinity, kInfinity}, high[2] = {-kInfinity, -kInfinity};
    for (const FlatTriangle& t : triangles) {
        const ProjectedTriangle p = projected(t, frame);
        const auto [x0, x1] = std::minmax_element(p.x.begin(), p.x.end());
        const auto [y0, y1] = std::minmax_element(p.y.begin(), p.y.end());
        low[0] = std::min(low[0], *x0);
        high[0] = std::max(high[0], *x1);
        low[1] = std::min(low[1], *y0);
        high[1] = std::max(high[1], *y1);
    }
    fit_side(low[0], high[0], 2 * slack, fit.x, fit.scale_x);
    fit_side(low[1], high[1], 2 * slack, fit.y, fit.scale_y);
    return fit;
}

}  // namespace

void SubfieldBuilder::rasterize(std::span<const FlatTriangle> triangles, std::span<const uint32_t> ids,
                                const Frame3& frame, const TileFit& fit) {
    touches_.clear();
    TileGrid grid = shape_.grid;
    // The slack is a length in the unit ball; on enlarged tiles it grows by the larger of both scales.
    grid.slack *= fit.largest_scale();
    for (uint32_t i = 0; i < triangles.size(); ++i) {
        const uint32_t id = ids.empty() ? i : ids[i];
        cover_tiles(projected(triangles[i], frame, fit), grid, [&](int x, int y, float low, float high) {
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
        x0 = std::min(x0, t.tile_x);
        x1 = std::max(x1, t.tile_x);
        y0 = std::min(y0, t.tile_y);
        y1 = std::max(y1, t.tile_y);
    }
    return {int(x0), int(y0), int(x1 - x0 + 1), int(y1 - y0 + 1)};
}

/// Counting sort by tile; keeps the order of triangles.
void SubfieldBuilder::sort_by_tile(const TileRect& rect) {
    first_.assign(rect.size() + 1, 0);
    const auto tile = [&](const Touch& t) { return rect.index(int(t.tile_x), int(t.tile_y)); };
    for (const Touch& t : touches_) ++first_[tile(t) + 1];
    for (size_t i = 0; i < rect.size(); ++i) first_[i + 1] += first_[i];
    sorted_.resize(touches_.size());
    // Filling advances each start to the start of the next tile ...
    for (const Touch& t : touches_) sorted_[first_[tile(t)]++] = t.entry;
    // ... so shifting them by one restores them.
    for (size_t i = rect.size(); i > 0; --i) first_[i] = first_[i - 1];
    first_[0] = 0;
}

void SubfieldBuilder::require_room(size_t words) const {
    if (pool_.size() + words >= std::numeric_limits<uint32_t>::max())
        throw std::length_error("a subfield lists at most 2^32 - 2 triangles, n_tiles is too large");
}

/// Appends the leaves of one tile to the pool.
/// Layout in the pool, from `first` on; the index is present only if the tile is split at medians:
///
///     [index of borders] [ends of leaves 0 ... L-1] [triangles of leaf 0] [of leaf 1] ... [of leaf L-1]
///
/// Ends count from the first triangle. A triangle that straddles leaves is listed in each of them.
Subfield::Tile SubfieldBuilder::add_tile(std::span<const TileEntry> entries) {
    if (entries.empty()) return {};
    TileBsp bsp;
    if (shape_.tile_ranges) {
        bsp.z0 = kInfinity;
        bsp.z1 = -kInfinity;
        for (const TileEntry& e : entries) {
            bsp.z0 = std::min(bsp.z0, e.low);
            bsp.z1 = std::max(bsp.z1, e.high);
        }
    }
    // A power of two: the halvings of the paper, laid out as equal slabs.
    bsp.leaves = 1 << tile_depth(entries.size(), shape_.bsp_depth, shape_.leaf_target);
    const size_t leaves = size_t(bsp.leaves);
    require_room(leaves + 1);
    const Subfield::Tile tile{uint32_t(pool_.size()), uint32_t(leaves), bsp.z0, bsp.z1};
    if (shape_.split == DepthSplit::kObject && leaves > 1) {
        pool_.push_back(uint32_t(borders_.size()));
        borders_.resize(borders_.size() + leaves);
        bsp.borders = borders_.data() + borders_.size() - leaves;
        object_borders(entries, bsp.leaves, middles_, borders_.data() + borders_.size() - leaves);
    }
    const size_t ends = pool_.size(), ids = ends + leaves;
    pool_.resize(ids);
    // Count, add up, fill: the entries ascend, so the ids of every leaf do, too.
    for (const TileEntry& e : entries)
        for (int l = bsp.leaf_of(e.low), last = bsp.leaf_of(e.high); l <= last; ++l)
            ++pool_[ends + size_t(l)];
    uint64_t sum = 0;
    for (size_t l = 0; l < leaves; ++l) {
        const uint32_t count = pool_[ends + l];
        pool_[ends + l] = uint32_t(sum);
        sum += count;  // the start for now; filling advances it to the end
    }
    require_room(sum);
    pool_.resize(ids + sum);
    for (const TileEntry& e : entries)
        for (int l = bsp.leaf_of(e.low), last = bsp.leaf_of(e.high); l <= last; ++l)
            pool_[ids + pool_[ends + size_t(l)]++] = e.id;
    return tile;
}

Subfield SubfieldBuilder::build(std::span<const FlatTriangle> triangles, std::span<const uint32_t> ids,
                                const Frame3& frame, bool tight) {
    Subfield made;
    // Without a box, the tiles cover the square around the ball (the default of `TileFit`).
    if (shape_.fit_box) made.fit = box_of(triangles, frame, shape_.grid.slack);
    rasterize(triangles, ids, frame, made.fit);
    made.rect = tight ? touched_rect() : TileRect{0, 0, shape_.grid.n, shape_.grid.n};
    sort_by_tile(made.rect);
    pool_.clear();
    borders_.clear();
    made.tiles_.reserve(made.tiles());
    for (size_t tile = 0; tile < made.tiles(); ++tile)
        made.tiles_.push_back(
            add_tile(std::span(sorted_).subspan(first_[tile], first_[tile + 1] - first_[tile])));
    // Copied with their exact size; the builder keeps its buffers for the next direction.
    made.pool_.assign(pool_.begin(), pool_.end());
    made.borders_.assign(borders_.begin(), borders_.end());
    return made;
}

}  // namespace viscache

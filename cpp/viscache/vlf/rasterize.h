#pragma once
// Rasterization of a triangle in a parallel subfield: which tiles it touches, and its depth range in each.
#include <algorithm>
#include <array>

#include "viscache/casters/flat_triangles.h"
#include "viscache/math/frame.h"

namespace viscache {

/// The n × n square tiles of [−1, 1]², half open except the last ones, and the dilation of coverage.
struct TileGrid {
    int n = 1;
    /// Covers the rounding errors of projected corners (3e-7), of clipping (1e-6) and of the kernels (1e-6
    /// for rays that start within four radii; other rays are moved closer first).
    float slack = 1e-5f;

    /// Tile of a coordinate along either axis. Coordinates beyond the border belong to the outermost tile.
    int tile_of(float x) const {
        // Clamped before the conversion: an int from a large float or NaN is undefined.
        const float place = (x + 1) * (0.5f * float(n));
        return place > 0 ? std::min(n - 1, int(std::min(place, float(n)))) : 0;
    }
    /// Lower border of tile i.
    float border(int i) const { return 2 * float(i) / float(n) - 1; }
};

/// The rectangle across the beams of a subfield that its tiles cover: its centre, and the scale that makes
/// it fill [−1, 1]². By default the square around the unit ball.
struct TileFit {
    float x = 0, y = 0;
    float scale_x = 1, scale_y = 1;
    float largest_scale() const { return std::max({1.f, scale_x, scale_y}); }
};

/// Corners in the canonical space of a subfield: tiles lie in x and y, beams run along z.
struct ProjectedTriangle {
    std::array<float, 3> x, y, z;
};

inline ProjectedTriangle projected(const FlatTriangle& t, const Frame3& frame, const TileFit& fit = {}) {
    const Vec3 a = frame.to_local(t.a), b = frame.to_local(t.b), c = frame.to_local(t.c);
    const auto x = [&](Vec3 p) { return (p.x - fit.x) * fit.scale_x; };
    const auto y = [&](Vec3 p) { return (p.y - fit.y) * fit.scale_y; };
    return {{x(a), x(b), x(c)}, {y(a), y(b), y(c)}, {a.z, b.z, c.z}};
}

/// A convex polygon: a clipped triangle.
struct CutPolygon {
    struct Corner {
        float x, y, z;
    };
    // Each of the four cuts adds at most one corner: 3 + 4 = 7.
    std::array<Corner, 8> corner;
    int size = 0;

    explicit CutPolygon(const ProjectedTriangle& t) : size(3) {
        for (size_t i = 0; i < 3; ++i) corner[i] = {t.x[i], t.y[i], t.z[i]};
    }
    /// Clips to sign · (axis coordinate) <= sign · limit [Sutherland, Hodgman 1974].
    void cut(float Corner::* axis, float limit, float sign) {
        const std::array<Corner, 8> before = corner;
        const int n = size;
        size = 0;
        for (int i = 0; i < n; ++i) {
            const Corner &p = before[size_t(i)], &q = before[size_t(i + 1 == n ? 0 : i + 1)];
            const float dp = sign * (limit - p.*axis), dq = sign * (limit - q.*axis);
            // A corner on the line stays, so a polygon that only touches the half plane is not lost.
            if (dp >= 0) corner[size_t(size++)] = p;
            if ((dp > 0 && dq < 0) || (dp < 0 && dq > 0)) {
                const float s = dp / (dp - dq);
                corner[size_t(size++)] = {p.x + s * (q.x - p.x), p.y + s * (q.y - p.y),
                                          p.z + s * (q.z - p.z)};
            }
        }
    }
    /// Minimum and maximum of one coordinate.
    std::array<float, 2> range(float Corner::* axis) const {
        float lo = kInfinity, hi = -kInfinity;
        for (int i = 0; i < size; ++i) {
            lo = std::min(lo, corner[size_t(i)].*axis);
            hi = std::max(hi, corner[size_t(i)].*axis);
        }
        return {lo, hi};
    }
};

/// [VLF Sec. 3.2] Calls visit(tile_x, tile_y, z_low, z_high) for every tile whose closed square, dilated by
/// the slack of the grid, overlaps the triangle. The depth range is that of the part inside the tile,
/// dilated as well. Proceeds row by row: the part of a convex polygon in a strip covers one run of tiles.
// Differs (V6): the paper walks edges 8-connected, then fills. A diagonal step that skips a touched tile
// would lose hits; this is the supercover. Depths are those of the polygon clipped to the tile, as in Section
// 5 of the paper.
template <class Visit>
void cover_tiles(const ProjectedTriangle& t, const TileGrid& grid, Visit visit) {
    using Corner = CutPolygon::Corner;
    const float e = grid.slack;
    const CutPolygon whole(t);
    const auto [x_low, x_high] = whole.range(&Corner::x);
    const auto [y_low, y_high] = whole.range(&Corner::y);
    const auto [z_low, z_high] = whole.range(&Corner::z);
    const int first_row = grid.tile_of(y_low - e), last_row = grid.tile_of(y_high + e);
    // Most triangles of a fine mesh lie in one tile and need no cut.
    if (first_row == last_row && grid.tile_of(x_low - e) == grid.tile_of(x_high + e)) {
        visit(grid.tile_of(x_low - e), first_row, z_low - e, z_high + e);
        return;
    }
    // One strip per row of tiles. What a convex polygon has in a strip covers a run of tiles without gaps:
    //
    //      |    |    |    |
    //     -+----+----+----+-
    //      | ## | ## | ## |      strip of one row: tiles from `first` to `last`
    //     -+----+----+----+-
    //      |    |    |    |
    for (int row = first_row; row <= last_row; ++row) {
        CutPolygon strip = whole;
        // The outermost rows and columns are not cut on the outer side: no part of the triangle lies beyond.
        if (row > first_row) strip.cut(&Corner::y, grid.border(row) - e, -1);
        if (row < last_row) strip.cut(&Corner::y, grid.border(row + 1) + e, 1);
        if (strip.size == 0) continue;  // touched only by rounding
        const auto [low, high] = strip.range(&Corner::x);
        const int first = grid.tile_of(low - e), last = grid.tile_of(high + e);
        for (int column = first; column <= last; ++column) {
            CutPolygon part = strip;
            if (column > first) part.cut(&Corner::x, grid.border(column) - e, -1);
            if (column < last) part.cut(&Corner::x, grid.border(column + 1) + e, 1);
            if (part.size == 0) continue;
            const auto [near, far] = part.range(&Corner::z);
            visit(column, row, near - e, far + e);
        }
    }
}

}  // namespace viscache

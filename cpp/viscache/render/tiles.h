#pragma once
// Tiles are the unit of work, of reuse and of determinism. They depend on parameters and scene only, never on
// threads.
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <vector>

namespace viscache {

struct Tile {
    int x0, y0, x1, y1;  ///< pixels [x0, x1) × [y0, y1)
};

/// Which edges tiles may have, in eye samples, and when they are as large as that.
struct TileRule {
    int least, most;  ///< powers of two
    size_t enough;    ///< edges grow while a frame has at least this number of tiles
};

/// Data of small tiles stay in the processor's cache, and many tiles keep many threads busy. 64² eye samples
/// take the least CPU time or within 5 % of it, cached or exact, and 32² within 11 %
/// (docs/performance/threads.md).
constexpr TileRule kTiles = {.least = 32, .most = 64, .enough = 64};
/// For frames whose eye points share many directions: the aligned batch (vlf/aligned_batch.h) sorts the
/// triangles of a direction once for all eye points of a tile.
constexpr TileRule kTilesOfDirections = {.least = 64, .most = 256, .enough = 16};

/// Edge in pixels of a tile of about samples_edge² eye samples: samples_edge/√spp, rounded to a power of two
/// of at least 4.
inline int tile_edge(int samples_edge, int spp) {
    // The edge shrinks by the root of the samples, so that a tile holds about as many eye samples
    const double edge = samples_edge / std::sqrt(double(spp));
    return std::max(4, int(std::exp2(std::round(std::log2(edge)))));
}

/// Edge in pixels of the tiles of a frame.
inline int tile_edge(const TileRule& rule, int width, int height, int spp) {
    const auto tiles = [&](int edge) {
        return size_t((width + edge - 1) / edge) * size_t((height + edge - 1) / edge);
    };
    // Halved until there are enough tiles, but never below the least: small frames then have fewer
    int samples = rule.most;
    while (samples > rule.least && tiles(tile_edge(samples, spp)) < rule.enough) samples /= 2;
    return tile_edge(samples, spp);
}

inline std::vector<Tile> cut_tiles(int width, int height, int edge) {
    std::vector<Tile> tiles;
    for (int y = 0; y < height; y += edge)
        for (int x = 0; x < width; x += edge)
            tiles.push_back({x, y, std::min(x + edge, width), std::min(y + edge, height)});
    return tiles;
}

/// Every `parts`-th tile from number `part` on. A part is spread over the whole frame.
inline std::vector<Tile> tiles_of_part(const std::vector<Tile>& tiles, int part, int parts) {
    std::vector<Tile> own;
    for (size_t i = size_t(part); i < tiles.size(); i += size_t(parts)) own.push_back(tiles[i]);
    return own;
}

/// Pixels of a tile along a Morton curve, as (x, y) relative to its corner.
inline std::vector<std::pair<uint16_t, uint16_t>> morton_pixels(int width, int height) {
    // The curve of the smallest square that holds the tile; what lies outside is skipped
    const uint32_t side = std::bit_ceil(uint32_t(std::max({width, height, 1})));
    std::vector<std::pair<uint16_t, uint16_t>> pixels;
    pixels.reserve(size_t(width) * height);
    for (uint64_t code = 0; code < uint64_t(side) * side; ++code) {
        uint32_t x = 0, y = 0;
        for (int bit = 0; bit < 16; ++bit) {
            x |= uint32_t(code >> (2 * bit) & 1) << bit;
            y |= uint32_t(code >> (2 * bit + 1) & 1) << bit;
        }
        if (int(x) < width && int(y) < height) pixels.emplace_back(uint16_t(x), uint16_t(y));
    }
    return pixels;
}

}  // namespace viscache

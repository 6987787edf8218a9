#pragma once
// Settings of the visibility field (Mortensen, Khanna, Yu, Slater 2007, here "VLF"), one row each.
//
// What reads the rows: FieldSettings::validate, the binding, and the help of viscache.Vlf.
#include <array>
#include <cstdint>
#include <tuple>

#include "viscache/casters/triangle_kernels.h"
#include "viscache/visibility/parameter_row.h"
#include "viscache/vlf/directions.h"
#include "viscache/vlf/subfield.h"

namespace viscache {

/// What the tiles of a direction cover: the square around the ball of the scene, or the bounding box of the
/// scene in that direction.
enum class FieldFit { kSphere, kBox };

template <>
inline constexpr std::array kNames<DepthSplit>{"uniform", "object"};
template <>
inline constexpr std::array kNames<LeafWalk>{"linear", "stack"};
template <>
inline constexpr std::array kNames<FieldFit>{"sphere", "psf_box"};

constexpr int kMostTiles = 4096;

/// What each is, and its range: kFieldRows.
struct FieldSettings {
    uint32_t n_directions = 513;
    int n_tiles = 128;
    int bsp_depth = -1;
    int leaf_target = 4;
    DepthSplit split = DepthSplit::kUniform;
    LeafWalk walk = LeafWalk::kLinear;
    bool tile_ranges = true;
    FieldFit fit = FieldFit::kSphere;
    TriangleKernel kernel = TriangleKernel::kWatertight;
    double head_room = 1;
    bool lazy = false;
    bool snap = false;
    uint64_t max_bytes = uint64_t{2} << 30;
    double max_build_s = 0;

    /// Throws std::invalid_argument with a message that says what must hold.
    void validate() const;
    /// The shape of the subfields. No setting may be open.
    SubfieldShape shape() const {
        return {{.n = n_tiles}, bsp_depth, leaf_target, split, tile_ranges, fit == FieldFit::kBox};
    }
};

// clang-format off
/// Everything that is said of the settings, but their defaults.
inline constexpr std::tuple kFieldRows{
    row("n_directions", &FieldSettings::n_directions, {.low = 1, .high = 8193, .open = 0},
        "l: 1, 3, 9, 33, 129, 513, 2049 or 8193 (2·4^k + 1)."),
    row("n_tiles", &FieldSettings::n_tiles, {.low = 1, .high = kMostTiles, .open = 0},
        "n: tiles along an edge of each direction's grid."),
    row("bsp_depth", &FieldSettings::bsp_depth, {.low = 0, .high = kMostBspDepthOfTile, .open = -1},
        "Maximum number of halvings of a tile's depth. \"auto\", for any of the three: chosen to fit "
        "`max_bytes`."),
    row("leaf_target", &FieldSettings::leaf_target, {.low = 0, .high = 1 << 20},
        "A tile is halved until its leaves have about this many triangles, at most `bsp_depth` times; 0: "
        "every tile is halved `bsp_depth` times."),
    row("split", &FieldSettings::split,
        "Tiles are cut into equal slabs, or at the medians of their triangles' depths."),
    row("walk", &FieldSettings::walk,
        "The paper's two ways through a tile's leaves. Never changes an answer."),
    row("tile_ranges", &FieldSettings::tile_ranges,
        "Depths are divided over each tile's own range, or over the scene's. The latter saves no memory: a "
        "tile keeps its range in either case, so that rays beside it can pass."),
    row("fit", &FieldSettings::fit,
        "What a direction's tiles cover: the square around the scene's bounding sphere, or the box of the "
        "triangles seen along it: finer tiles where a scene is flat. Never changes an answer."),
    row("kernel", &FieldSettings::kernel,
        "\"wald\" is the paper's: fewer operations, but a ray may slip through an edge."),
    row("head_room", &FieldSettings::head_room, {.low = 1, .high = 1000},
        "Radius of the field's ball over that of the scene's bounding sphere: room for objects that move."),
    row("lazy", &FieldSettings::lazy,
        "A direction is built by the first ray that needs it. Where the budget ends, those longest unused "
        "are evicted."),
    row("snap", &FieldSettings::snap,
        "Approximate: every ray runs along its nearest axis, up to 5° off at l = 513."),
    row("max_bytes", &FieldSettings::max_bytes, {.low = 1},
        "Memory budget. It includes one builder thread's working memory; the number of builder threads is "
        "reduced to fit. A field that needs more raises MemoryError before it is built."),
    row("max_build_s", &FieldSettings::max_build_s, {.low = 0},
        "CPU seconds that \"auto\" parameters may take to build, by rule of thumb; 0: any."),
};
// clang-format on

/// Throws std::invalid_argument unless n_tiles is in [1, 4096].
inline void check_tiles(int n_tiles) {
    detail::require(n_tiles >= 1 && n_tiles <= kMostTiles,
                    "n_tiles must be in [1, " + std::to_string(kMostTiles) + "]", n_tiles);
}

inline void FieldSettings::validate() const {
    check_rows(kFieldRows, *this);
    detail::require(n_directions == 0 || is_direction_count(n_directions),
                    "n_directions must be 1, 3, 9, 33, 129, 513, 2049 or 8193 (2·4^k + 1)", n_directions);
}

}  // namespace viscache

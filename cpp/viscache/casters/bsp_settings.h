#pragma once
// Settings of the single-ray BSP tracer, one row each. What reads the rows: BspSettings::validate, the
// binding, and the help of viscache.Bsp.
#include <cstdint>
#include <tuple>

#include "viscache/casters/triangle_kernels.h"
#include "viscache/visibility/parameter_row.h"

namespace viscache {

constexpr int kMostBspDepth = 40;

/// What each is, and its range: kBspRows.
struct BspSettings {
    int max_depth = 0;
    int leaf_size = 8;
    TriangleKernel kernel = TriangleKernel::kWatertight;
    uint64_t max_bytes = uint64_t{2} << 30;

    /// Throws std::invalid_argument with a message that says what must hold.
    void validate() const;
    /// Maximum depth of the tree over `n` triangles.
    int depth(size_t n) const;
};

// clang-format off
/// Everything that is said of the settings, but their defaults.
inline constexpr std::tuple kBspRows{
    row("max_depth", &BspSettings::max_depth,
        {.low = 1, .high = kMostBspDepth, .open = 0, .open_word = nullptr},
        "5 + log2 of the number of triangles by default."),
    row("leaf_size", &BspSettings::leaf_size, {.low = 1, .high = 1024},
        "Cells of as many triangles or fewer are not halved."),
    row("kernel", &BspSettings::kernel,
        "\"wald\" is the paper's: fewer operations, but a ray may slip through an edge."),
    row("max_bytes", &BspSettings::max_bytes, {.low = 1},
        "A tree that needs more raises MemoryError; so does one that cuts triangles into countless pieces "
        "(deep trees over many triangles side by side), after some seconds instead of hours."),
};
// clang-format on

inline void BspSettings::validate() const { check_rows(kBspRows, *this); }

}  // namespace viscache

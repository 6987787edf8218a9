#pragma once
// The tree of the single-ray BSP tracer: cells are halved across their longest side.
#include <bit>
#include <cstdint>
#include <new>
#include <span>
#include <string>
#include <vector>

#include "viscache/casters/bsp_settings.h"
#include "viscache/casters/flat_triangles.h"
#include "viscache/math/parallel.h"

namespace viscache {

/// Thrown when a structure would exceed its budget.
class OverBudget : public std::bad_alloc {
public:
    explicit OverBudget(std::string text) : text_(std::move(text)) {}
    const char* what() const noexcept override { return text_.c_str(); }

private:
    std::string text_;
};

/// 8 bytes: a plane and the first of two adjacent children, or the triangles of a leaf.
struct BspNode {
    uint32_t value;  ///< bits of the plane's coordinate; for a leaf, its first entry in the list
    uint32_t word;   ///< axis, or 3 for a leaf; above these bits the first child, or the number of entries

    static BspNode inner(int axis, float plane, uint32_t children) {
        return {std::bit_cast<uint32_t>(plane), children << 2 | uint32_t(axis)};
    }
    static BspNode leaf(uint32_t first, uint32_t count) { return {first, count << 2 | 3}; }
    bool is_leaf() const { return (word & 3) == 3; }
    int axis() const { return int(word & 3); }
    float plane() const { return std::bit_cast<float>(value); }
    uint32_t children() const { return word >> 2; }
    uint32_t first() const { return value; }
    uint32_t count() const { return word >> 2; }
};

struct BspTree {
    std::vector<BspNode> nodes;  ///< node 0 is the root; empty if there are no triangles
    std::vector<uint32_t> ids;   ///< triangles of the leaves; one across a plane is listed on both sides
    Bounds bounds;               ///< cell of the root
    int max_depth = 0;           ///< the limit
    int depth = 0;               ///< depth of the deepest leaf

    uint64_t bytes() const { return nodes.size() * sizeof(BspNode) + ids.size() * sizeof(uint32_t); }
};

/// Cells extend beyond their planes by this many units in the last place of the largest coordinate, so that
/// rounding cannot place a hit in a cell that does not list its triangle.
constexpr float kCellUlps = 16;

/// Limits on the tests of a triangle against a cell during a build. They allow about a hundred times what
/// scenes need at the default depth, which takes some seconds.
constexpr uint64_t kMostTests = uint64_t{1} << 23, kMostTestsPerTriangle = 1 << 12;

/// Builds the tree. The result is the same for any number of threads. Throws OverBudget if the tree exceeds
/// `settings.max_bytes`, or if the build needs more tests than `kMostTests` and `kMostTestsPerTriangle`
/// allow.
BspTree build_bsp(std::span<const FlatTriangle> triangles, const BspSettings& settings, int threads,
                  const Control& control);

/// True if a triangle overlaps a box. May also return true for a miss by a few units in the last place.
bool triangle_meets_box(const FlatTriangle& triangle, Vec3 center, Vec3 half);

}  // namespace viscache

#pragma once
// Triangles for shafts: a tree 16 wide whose leaves are blocks of 16 triangles.
#include <cstdint>
#include <span>
#include <vector>

#include "viscache/math/bounds.h"
#include "viscache/math/parallel.h"
#include "viscache/math/vec.h"

namespace viscache {

constexpr size_t kShaftLanes = 16;  ///< children of a node, triangles of a block, points of a packet

struct ShaftTriangle {
    Vec3 corner[3];
    /// False: a hit never blocks for certain, because the material has holes. Only a ray can tell.
    bool solid = true;
};

/// Sixteen children.
struct alignas(64) ShaftNode {
    float lo[3][kShaftLanes], hi[3][kShaftLanes];
    float size[kShaftLanes];  ///< longest side of the child's box
    float
        width[kShaftLanes];  ///< greatest of the least heights of its triangles: no wider box can be covered
    int32_t child[kShaftLanes];  ///< node, or ~block
    uint32_t used, leaves;       ///< masks of the children in use, and of those that are blocks
};

/// Sixteen triangles. Unused lanes hold NaN.
struct alignas(64) ShaftBlock {
    float corner[9][kShaftLanes];  ///< x, y, z of corners 0, 1, 2
    float longest[kShaftLanes];    ///< longest side, rounded up and at least kShortestSide
    uint32_t used, holed;          ///< masks of the triangles in use, and of those that are not solid
};

/// Sides count as at least this long (a tree's coordinates are scaled to a size of 1 to 2), so that no bound
/// underflows. Shorter ones only leave more to rays.
constexpr float kShortestSide = 0x1p-20f;

struct ShaftTree {
    std::vector<ShaftNode> nodes;  ///< nodes[0] is the root
    std::vector<ShaftBlock> blocks;
    Bounds bounds;
    uint64_t bytes() const { return nodes.size() * sizeof(ShaftNode) + blocks.size() * sizeof(ShaftBlock); }
};

/// Bytes of a tree over so many triangles, from above; trees need about two thirds of it.
uint64_t most_shaft_bytes(uint64_t triangles);

/// Splits by the surface area heuristic. Corners must be finite. The tree is the same for any number of
/// threads.
ShaftTree build_shaft_tree(std::span<const ShaftTriangle> triangles, int threads, const Control& control);

}  // namespace viscache

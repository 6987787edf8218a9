#pragma once
// A binary tree over triangles by the surface area heuristic: the first stage of a shaft tree.
#include <span>
#include <vector>

#include "viscache/shafts/shaft_tree.h"

namespace viscache {

struct ShaftPart {
    Bounds box;
    int32_t left = -1, right = -1;
    uint32_t first = 0, count = 0;  ///< a range of ShaftParts::order
    float width = 0;                ///< greatest of the least heights of its triangles
    bool is_leaf() const { return left < 0; }
};

struct ShaftParts {
    std::vector<uint32_t> order;   ///< indices of the triangles
    std::vector<ShaftPart> parts;  ///< parts[0] is the root; leaves have at most kShaftLanes triangles
};

/// The same parts for any number of threads. There must be a triangle.
ShaftParts split_into_parts(std::span<const ShaftTriangle> triangles, int threads, const Control& control);

/// Longest side of a triangle, exact or nearly so.
double longest_side(const ShaftTriangle& triangle);

}  // namespace viscache

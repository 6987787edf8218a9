#pragma once
// Precomputed directions of the quadtree nodes over the equal-area map: the sample directions of reflection,
// and cones that enclose a node.
#include <span>
#include <vector>

#include "viscache/math/vec.h"

namespace viscache {

/// Range of levels of the leaves of a reflection tree, and how many levels deeper its samples are.
constexpr int kBaseLevel = 5, kDeepestLevel = 7, kSampleLevels = 1;

/// Directions as arrays of components, along the Morton curve.
struct DirectionTable {
    std::vector<float> x, y, z;
    Vec3 at(size_t i) const { return {x[i], y[i], z[i]}; }
};

/// Centres of the nodes of one level in [kBaseLevel, kDeepestLevel + kSampleLevels].
const DirectionTable& node_centres(int level);
/// Sine of the angular radius of each node around its centre, for levels kBaseLevel to kDeepestLevel. A node
/// with n·centre <= −sine lies below the plane of n.
std::span<const float> node_radius_sines(int level);

}  // namespace viscache

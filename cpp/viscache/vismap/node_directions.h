#pragma once
// Directions of the quadtree's nodes over the equal-area map, computed once: where reflection is looked at,
// and cones that hold a node.
#include <span>
#include <vector>

#include "viscache/math/vec.h"

namespace viscache {

/// Levels of the leaves of a reflection tree, and how much deeper its samples lie.
constexpr int kBaseLevel = 5, kDeepestLevel = 7, kSampleLevels = 1;

/// Directions side by side, along the Morton curve.
struct DirectionTable {
    std::vector<float> x, y, z;
    Vec3 at(size_t i) const { return {x[i], y[i], z[i]}; }
};

/// Centres of the nodes of one level in [kBaseLevel, kDeepestLevel + kSampleLevels].
const DirectionTable& node_centres(int level);
/// Sine of the angle around the centre within which all of the node lies, for levels kBaseLevel to
/// kDeepestLevel: a node with n·centre <= −sine lies below the plane of n.
std::span<const float> node_radius_sines(int level);

}  // namespace viscache

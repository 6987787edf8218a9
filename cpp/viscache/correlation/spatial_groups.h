#pragma once
// Spatial groups of points, over which correlation statistics are resampled.
#include <cstdint>
#include <span>
#include <vector>

#include "viscache/math/vec.h"

namespace viscache {

constexpr int kSpatialGroups = 16;

/// Group of every point, in [0, kSpatialGroups). The points are split four times at the median of the
/// longest axis, so that groups are compact and their sizes differ by at most one. Ties in a coordinate are
/// broken by the index of the point.
std::vector<int32_t> spatial_groups(std::span<const Vec3> points);

}  // namespace viscache

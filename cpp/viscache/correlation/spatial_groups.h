#pragma once
// Blocks of space: the groups over which correlation statistics are resampled.
#include <cstdint>
#include <span>
#include <vector>

#include "viscache/math/vec.h"

namespace viscache {

constexpr int kSpatialGroups = 16;

/// Group of every point, in [0, kSpatialGroups): halved four times at the median of the longest axis, so
/// that groups are compact and their sizes differ by one at most. Points of equal coordinates are told
/// apart by their number.
std::vector<int32_t> spatial_groups(std::span<const Vec3> points);

}  // namespace viscache

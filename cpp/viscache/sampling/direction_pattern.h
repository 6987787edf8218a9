#pragma once
// Sets of directions: one in each cell of the equal-area octahedral map.
#include <cstdint>
#include <vector>

#include "viscache/math/vec.h"

namespace viscache {

enum class PatternKind {
    kCentres,   ///< the cells' centres
    kJittered,  ///< uniform in each cell
    kLloyd,     ///< jittered, then spread evenly over the sphere by Lloyd's iteration; none leaves its cell
};

/// Unit directions of a map_size × map_size map, row by row. The same seed gives the same set; centres have
/// none.
std::vector<Vec3> direction_pattern(int map_size, PatternKind kind, uint64_t seed);

}  // namespace viscache

#pragma once
// Sets of directions with one direction in each cell of the equal-area octahedral map.
#include <cstdint>
#include <vector>

#include "viscache/math/vec.h"

namespace viscache {

enum class PatternKind {
    kCentres,   ///< centres of the cells
    kJittered,  ///< uniform in each cell
    kLloyd,  ///< jittered, then spread evenly over the sphere by Lloyd's iteration; each direction stays in
             ///< its cell
};

/// Unit directions of a map_size × map_size map, row by row. The same seed gives the same set; kCentres
/// ignores the seed.
std::vector<Vec3> direction_pattern(int map_size, PatternKind kind, uint64_t seed);

}  // namespace viscache

#pragma once
// Rows of bits, one per point: what they are asked with, and blocks of them for an oracle.
#include <span>

#include "viscache/math/bits.h"
#include "viscache/math/vec.h"
#include "viscache/visibility/oracle.h"

namespace viscache {

struct RowInput {
    std::span<const Vec3> position;   ///< on surfaces
    std::span<const Vec3> normal;     ///< unit vectors, one per position
    std::span<const Vec3> direction;  ///< unit vectors, the same for all points
    float t_max = kInfinity;          ///< length of the rays
};

/// The directions as the far ends of a block.
FarEnds far_ends(std::span<const Vec3> directions, float t_max);

/// Some points and the far ends above their tangent planes, ready for an oracle.
struct RowBlock {
    EyeBlock eyes;
    BitMatrix wanted;
    void fill(const RowInput& input, const FarEnds& ends, std::span<const uint32_t> points, float extent);
};

}  // namespace viscache

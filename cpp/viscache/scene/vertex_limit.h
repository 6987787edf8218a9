#pragma once
// How far from the origin geometry may lie.
#include "viscache/math/vec.h"

namespace viscache {

/// Limit on the coordinates of vertices. In its triangle test, Embree multiplies up to 144 times the cube of
/// the largest coordinate; single precision ends at 3.4e38.
constexpr float kMaxVertex = 1e12f;

inline bool is_usable_vertex(Vec3 p) {
    return is_finite(p) && std::max(max_component(p), max_component(-p)) <= kMaxVertex;
}

}  // namespace viscache

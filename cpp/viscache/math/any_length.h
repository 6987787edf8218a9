#pragma once
// Lengths and directions whose squares leave the range of single precision: normals of small triangles are
// products of their edges. Within the range, results have the bits of length and normalize.
#include <algorithm>
#include <cmath>

#include "viscache/math/vec.h"

namespace viscache {

/// A vector scaled into range, and the factor that scales it back.
struct ScaledVector {
    Vec3 vector;
    float factor;
};

inline ScaledVector in_range(Vec3 a) {
    const float l = length(a);
    const float most = std::max({std::fabs(a.x), std::fabs(a.y), std::fabs(a.z)});
    // Squares of such lengths are normal floats.
    const bool fits = l > 1e-18f && l < 1e18f;
    if (fits || !(most > 0) || !std::isfinite(most)) return {a, 1};
    return {a / most, most};
}

/// The length of a vector.
inline float any_length(Vec3 a) {
    const ScaledVector s = in_range(a);
    return s.factor * length(s.vector);
}
/// The unit vector along `a`; the zero vector stays zero.
inline Vec3 any_direction(Vec3 a) { return normalize(in_range(a).vector); }

}  // namespace viscache

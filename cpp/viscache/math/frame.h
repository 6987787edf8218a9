#pragma once
// Orthonormal frames around a unit normal (Duff et al. 2017, "Building an orthonormal basis, revisited").
#include "viscache/math/vec.h"

namespace viscache {

struct Frame3 {
    Vec3 x, y, z;

    Vec3 to_world(Vec3 v) const { return x * v.x + y * v.y + z * v.z; }
    Vec3 to_local(Vec3 v) const { return {dot(v, x), dot(v, y), dot(v, z)}; }
};

/// Right-handed frame whose z axis is the unit vector `n`.
inline Frame3 frame_around(Vec3 n) {
    // With the sign of z, the denominator s + n.z is never below 1 in size: no branch near the pole −z.
    const float s = std::copysign(1.f, n.z);
    const float a = -1.f / (s + n.z);
    const float b = n.x * n.y * a;
    return {{1.f + s * n.x * n.x * a, s * b, -s * n.x}, {b, s + n.y * n.y * a, -n.y}, n};
}

}  // namespace viscache

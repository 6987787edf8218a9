#pragma once
// A point on a surface, as shading needs it.
#include "viscache/scene/material.h"

namespace viscache {

struct SurfacePoint {
    Vec3 position;
    Vec3 ng;  ///< unit geometric normal (orientation of the triangle); zero for a degenerate triangle
    Vec3 ns;  ///< unit shading normal, on the side of ng
    Vec2 uv;
    int material = 0;
    Rgb base_color;  ///< base colour with its texture applied
    Rgb emission;    ///< radiance leaving on the side of ng (either side when emits_two_sided)
    bool emits_two_sided = false;
    Vec3 dndu, dndv;    ///< change of the (unnormalised) shading normal along the triangle's edges 1 and 2
    Vec3 edge1, edge2;  ///< world edges of the triangle
};

}  // namespace viscache

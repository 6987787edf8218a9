#pragma once
// A point on a surface, with the attributes that shading needs.
#include "viscache/scene/material.h"

namespace viscache {

struct SurfacePoint {
    Vec3 position;
    Vec3 ng;  ///< unit geometric normal (orientation of the triangle); zero for a degenerate triangle
    Vec3 ns;  ///< unit shading normal, on the same side as ng
    Vec2 uv;
    int material = 0;
    Rgb base_color;          ///< albedo of the Lambertian part, with its images applied
    Rgb specular;            ///< of the material, with its images applied
    float roughness = 0.1f;  ///< the same
    Rgb transmission;        ///< the same, of materials that light passes
    float metallic = 0;      ///< share of metal, with its image applied
    Rgb emission;            ///< radiance emitted on the side of ng (on both sides when emits_two_sided)
    bool emits_two_sided = false;
};

}  // namespace viscache

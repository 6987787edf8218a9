#pragma once
// The lights of a frozen scene, in the form that samplers use.
#include <vector>

#include "viscache/sampling/distribution.h"
#include "viscache/scene/description.h"

namespace viscache {

/// One emitting triangle in world space.
struct EmissiveTriangle {
    Vec3 a, b, c;
    Vec3 normal;  ///< unit, on the emitting side
    Rgb radiance;
    float area;
    bool two_sided;
    bool opaque;  ///< no holes: hides what lies behind it
};

/// Area lights: triangles first, then spheres.
struct AreaLights {
    std::vector<EmissiveTriangle> triangles;
    std::vector<SphereLight> spheres;
    Distribution1D choice;  ///< by power, over triangles, then spheres; empty when there are none
    bool empty() const { return triangles.empty() && spheres.empty(); }
    size_t size() const { return triangles.size() + spheres.size(); }
};

}  // namespace viscache

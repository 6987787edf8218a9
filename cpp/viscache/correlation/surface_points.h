#pragma once
// Points on the surfaces of a scene, between which visibility is correlated.
#include <vector>

#include "viscache/math/parallel.h"
#include "viscache/scene/camera.h"
#include "viscache/scene/scene.h"
#include "viscache/visibility/ray_caster.h"

namespace viscache {

/// Points in order of their spatial group and at random inside one; index i is the same point everywhere.
/// Geometry alone decides what is a surface: mirrors and glass are, cut-out holes and the spheres of sphere
/// lights are not.
struct SurfacePoints {
    std::vector<Vec3> position;
    std::vector<Vec3> normal;          ///< unit geometric normal; its hemisphere is what the point can see
    std::vector<Vec3> shading_normal;  ///< unit, turned as `normal` is
    std::vector<int32_t> group;        ///< see spatial_groups.h
    std::vector<uint32_t> stratum;     ///< camera: pixel, row-major; area: number along the surfaces
    uint32_t width = 0,
             height = 0;       ///< strata: columns and rows of the camera's image; area: their number, 1
    uint64_t bad_normals = 0;  ///< strata left out because the triangle there has no normal
    uint64_t misses = 0;       ///< strata left out because no surface is there
};

/// Where a camera sees the scene: primary hits, one at a random place of each pixel of an image just fine
/// enough for n of them; which pixels are left out is random. The normal is turned to the camera. Throws
/// std::invalid_argument when surfaces fill less than a thousandth of the image.
SurfacePoints camera_points(const Scene& scene, const RayCaster& caster, const Camera& camera, size_t n,
                            uint64_t seed, int threads, const Control& control);

/// Uniform over the area of all placed triangles, stratified along their sequence; the normal is that of
/// the triangle's winding. Throws std::invalid_argument when less than a thousandth of the area is solid.
SurfacePoints area_points(const Scene& scene, size_t n, uint64_t seed, const Control& control);

}  // namespace viscache

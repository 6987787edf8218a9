#pragma once
// Points on the surfaces of a scene, for correlating visibility between them.
#include <vector>

#include "viscache/math/parallel.h"
#include "viscache/scene/camera.h"
#include "viscache/scene/scene.h"
#include "viscache/visibility/ray_caster.h"

namespace viscache {

/// Points sorted by spatial group, in random order within a group. The same index is the same point in all
/// arrays. Geometry alone defines a surface: mirrors and glass are included; cut-out holes and the spheres
/// of sphere lights are not.
struct SurfacePoints {
    std::vector<Vec3> position;
    std::vector<Vec3> normal;          ///< unit geometric normal; the point sees the hemisphere around it
    std::vector<Vec3> shading_normal;  ///< unit vector on the same side as `normal`
    std::vector<int32_t> group;        ///< see spatial_groups.h
    std::vector<uint32_t> stratum;  ///< camera: pixel, row-major; area: position in the sequence of surfaces
    uint32_t width = 0,
             height = 0;       ///< strata. Camera: columns and rows of the image; area: their number, 1
    uint64_t bad_normals = 0;  ///< strata skipped because their triangle has no normal
    uint64_t misses = 0;       ///< strata skipped because there is no surface
};

/// Points that a camera sees: one primary hit at a random position in each pixel of an image that is just
/// fine enough for n points. The pixels that are left out are chosen at random. Normals face the camera.
/// Throws std::invalid_argument if surfaces fill less than a thousandth of the image.
SurfacePoints camera_points(const Scene& scene, const RayCaster& caster, const Camera& camera, size_t n,
                            uint64_t seed, int threads, const Control& control);

/// Points uniform over the area of all placed triangles, stratified along their sequence. The normal follows
/// the triangle's winding. Throws std::invalid_argument if less than a thousandth of the area is solid.
SurfacePoints area_points(const Scene& scene, size_t n, uint64_t seed, const Control& control);

}  // namespace viscache

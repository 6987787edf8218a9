#pragma once
// Where the camera's pixels look: the points that ask the cache, each with its pixel's size there.
#include "viscache/math/parallel.h"
#include "viscache/scene/camera.h"
#include "viscache/scene/scene.h"
#include "viscache/visibility/ray_caster.h"
#include "viscache/vismap/map_cache.h"

namespace viscache {

struct PixelRules {
    float reach = 0.05f;      ///< d_max in widths of the image, as long as a pixel is wide at the point
    float most_reach = 0.1f;  ///< of the scene's diagonal: d_max is not longer
    float least_cos = 0.05f;  ///< grazing pixels count as seen under this cosine
};

struct PixelPoints {
    std::vector<CachePoint> points;  ///< normals are geometric, turned to the camera; unusable: nothing hit
    uint64_t misses = 0, bad_normals = 0;
};

/// First hits of the camera's rays through one place of every pixel, row-major; `at` in pixels from its
/// upper left corner. A pixel of area a projects to the area t²·a·cos³φ / |n·ω|.
PixelPoints pixel_points(const Scene& scene, const RayCaster& caster, const Camera& camera, int width,
                         int height, Vec2 at, const PixelRules& rules, int threads, const Control& control);
/// The same through the places of a sample of all pixels (pixel_place).
PixelPoints sample_points(const Scene& scene, const RayCaster& caster, const Camera& camera, int width,
                          int height, uint64_t seed, uint32_t sample, const PixelRules& rules, int threads,
                          const Control& control);
/// First hits of n rays, stratified over the image, with the pixel sizes of an image of width × height.
PixelPoints startup_points(const Scene& scene, const RayCaster& caster, const Camera& camera, int width,
                           int height, size_t n, uint64_t seed, const PixelRules& rules,
                           const Control& control);

}  // namespace viscache

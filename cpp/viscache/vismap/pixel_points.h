#pragma once
// The points seen through the pixels of a camera, at which the cache is looked up, each with the size of its
// pixel there.
#include "viscache/math/parallel.h"
#include "viscache/scene/camera.h"
#include "viscache/scene/scene.h"
#include "viscache/visibility/ray_caster.h"
#include "viscache/vismap/map_cache.h"

namespace viscache {

struct PixelRules {
    float reach =
        0.05f;  ///< d_max as a fraction of the image width, measured by the width of a pixel at the point
    float most_reach = 0.1f;  ///< upper limit of d_max as a fraction of the scene's diagonal
    float least_cos = 0.05f;  ///< lower limit of the cosine at grazing pixels
};

struct PixelPoints {
    std::vector<CachePoint> points;  ///< normals are geometric and face the camera; unusable: nothing was hit
    uint64_t misses = 0, bad_normals = 0;
};

/// First hits of camera rays through one position of every pixel, row-major; `at` is measured in pixels from
/// the upper left corner of the pixel. A pixel of area a has the projected area t²·a·cos³φ / |n·ω|.
PixelPoints pixel_points(const Scene& scene, const RayCaster& caster, const Camera& camera, int width,
                         int height, Vec2 at, const PixelRules& rules, int threads, const Control& control);
/// The same at the positions of one sample of every pixel (pixel_place).
PixelPoints sample_points(const Scene& scene, const RayCaster& caster, const Camera& camera, int width,
                          int height, uint64_t seed, uint32_t sample, const PixelRules& rules, int threads,
                          const Control& control);
/// First hits of n rays, stratified over the image, with the pixel sizes of an image of width × height.
PixelPoints startup_points(const Scene& scene, const RayCaster& caster, const Camera& camera, int width,
                           int height, size_t n, uint64_t seed, const PixelRules& rules,
                           const Control& control);

}  // namespace viscache

#pragma once
// The lights of a frozen scene, in the form that samplers use.
#include <vector>

#include "viscache/sampling/distribution.h"
#include "viscache/scene/description.h"

namespace viscache {

/// One emitting triangle in world space.
struct EmissiveTriangle {
    Vec3 a, b, c;
    Vec3 normal;   ///< unit, on the emitting side
    Rgb radiance;  ///< mean over the triangle
    float area;
    float extent;  ///< surface_extent.h
    bool two_sided;
    bool opaque;  ///< no holes: hides what lies behind it
};

/// The image of an emitting triangle: the radiance at a point is `scale` times the image at its uv.
struct EmissiveImage {
    const Image* image = nullptr;  ///< nullptr: the same radiance everywhere
    Rgb scale{};
    Vec2 uv[3]{};
};

Rgb image_radiance(const EmissiveImage& picture, Vec2 weights);
/// Mean of `image_radiance` over the triangle: one sample per texel that it covers, or `most_samples`.
Rgb mean_radiance(const EmissiveImage& picture, size_t most_samples);

/// Area lights: triangles first, then spheres.
struct AreaLights {
    std::vector<EmissiveTriangle> triangles;
    std::vector<SphereLight> spheres;
    std::vector<EmissiveImage> images;  ///< one per triangle; empty if no light has an image
    Distribution1D choice;              ///< by power, over triangles, then spheres; empty when there are none
    bool empty() const { return triangles.empty() && spheres.empty(); }
    size_t size() const { return triangles.size() + spheres.size(); }
    /// Radiance of a triangle at the barycentric weights of its vertices b and c.
    Rgb radiance_at(size_t triangle, Vec2 weights) const {
        if (images.empty() || !images[triangle].image) return triangles[triangle].radiance;
        return image_radiance(images[triangle], weights);
    }
};

}  // namespace viscache

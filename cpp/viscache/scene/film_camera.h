#pragma once
// Primary rays of a pinhole camera for a given image size.
#include <optional>

#include "viscache/scene/camera.h"

namespace viscache {

struct FilmCamera {
    Camera camera;
    int width, height;
    float half_width, half_height;  ///< half extents of the image plane at distance 1

    FilmCamera(const Camera& c, int w, int h) : camera(c), width(w), height(h) {
        const float t = std::tan(0.5f * c.fov_y_rad);
        half_height = c.fov_is_horizontal ? t * h / w : t;
        half_width = c.fov_is_horizontal ? t : t * w / h;
    }
    /// Unnormalised direction through pixel coordinates (x to the right, y down); its forward component is 1.
    Vec3 direction(float x, float y) const {
        return camera.forward + camera.right * ((2 * x / width - 1) * half_width) +
               camera.up * ((1 - 2 * y / height) * half_height);
    }
    /// Row-major index of the pixel that looks along `d`. Empty if `d` misses the film or points behind the
    /// camera.
    std::optional<uint32_t> pixel_of(Vec3 d) const {
        const float depth = dot(d, camera.forward);
        if (!(depth > 0)) return std::nullopt;
        const float x = 0.5f * width * (1 + dot(d, camera.right) / (depth * half_width));
        const float y = 0.5f * height * (1 - dot(d, camera.up) / (depth * half_height));
        if (!(x >= 0 && x < float(width) && y >= 0 && y < float(height))) return std::nullopt;
        return uint32_t(y) * uint32_t(width) + uint32_t(x);
    }
    /// Area of one pixel on the plane at distance 1.
    float pixel_area() const { return 4 * half_width * half_height / (float(width) * float(height)); }
    /// Change of `direction` per pixel.
    Vec3 step_x() const { return camera.right * (2 * half_width / width); }
    Vec3 step_y() const { return camera.up * (-2 * half_height / height); }
};

}  // namespace viscache

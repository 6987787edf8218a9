#pragma once
// Primary rays of a camera for a given image size.
#include <optional>

#include "viscache/scene/camera.h"

namespace viscache {

struct FilmCamera {
    Camera camera;
    int width, height;
    float half_width, half_height;  ///< half extents of the image plane at distance 1; orthographic: anywhere

    FilmCamera(const Camera& c, int w, int h) : camera(c), width(w), height(h) {
        const float t = c.is_orthographic() ? 0.5f * c.view_height : std::tan(0.5f * c.fov_y_rad);
        half_height = c.fov_is_horizontal ? t * h / w : t;
        half_width = c.fov_is_horizontal ? t : t * w / h;
    }
    /// Unnormalised direction through pixel coordinates (x to the right, y down); its forward component is 1.
    Vec3 direction(float x, float y) const {
        return camera.is_orthographic() ? camera.forward : moved(camera.forward, x, y);
    }
    /// Start of the ray through pixel coordinates.
    Vec3 origin(float x, float y) const {
        return camera.is_orthographic() ? moved(camera.origin, x, y) : camera.origin;
    }
    /// Row-major index of the pixel that sees a point, given by the vector `d` from `camera.origin` to it; in
    /// a pinhole its length does not matter. Empty if `d` misses the film or points behind the camera.
    std::optional<uint32_t> pixel_of(Vec3 d) const {
        float depth = dot(d, camera.forward);
        if (!(depth > 0)) return std::nullopt;
        if (camera.is_orthographic()) depth = 1;
        const float x = 0.5f * width * (1 - 2 * camera.shift_x + dot(d, camera.right) / (depth * half_width));
        const float y = 0.5f * height * (1 + 2 * camera.shift_y - dot(d, camera.up) / (depth * half_height));
        if (!(x >= 0 && x < float(width) && y >= 0 && y < float(height))) return std::nullopt;
        return uint32_t(y) * uint32_t(width) + uint32_t(x);
    }
    /// Area of one pixel on the plane at distance 1.
    float pixel_area() const { return 4 * half_width * half_height / (float(width) * float(height)); }
    /// Area of one pixel across a ray after `distance`. `cosine`: between the ray and the optical axis.
    float pixel_area_at(float cosine, float distance) const {
        if (camera.is_orthographic()) return pixel_area();
        return pixel_area() * cosine * cosine * cosine * distance * distance;
    }

private:
    /// `centre` moved in the image plane to pixel coordinates.
    Vec3 moved(Vec3 centre, float x, float y) const {
        return centre + camera.right * ((2 * x / width - 1 + 2 * camera.shift_x) * half_width) +
               camera.up * ((1 - 2 * y / height + 2 * camera.shift_y) * half_height);
    }
};

}  // namespace viscache

#pragma once
// Pinhole and orthographic cameras.
#include <string>

#include "viscache/math/frame.h"

namespace viscache {

struct Camera {
    std::string name = "camera";
    Vec3 origin{0, 0, 0};
    Vec3 right{1, 0, 0}, up{0, 1, 0},
        forward{0, 0, -1};           ///< orthonormal; image x grows along right, image y against up
    float fov_y_rad = 0.8f;          ///< full vertical angle of view
    int width = 640, height = 400;   ///< size given by the file; the size passed to render takes precedence
    bool fov_is_horizontal = false;  ///< true: `fov_y_rad` is the angle across the width instead
    float view_height = 0;  ///< > 0: parallel rays, and the picture is so high in scene units (so wide where
                            ///< `fov_is_horizontal`); `fov_y_rad` is not used. 0: a pinhole
    float shift_x = 0, shift_y = 0;  ///< the picture is a part of a wider film: its centre lies so many
                                     ///< widths right of the axis `forward`, and so many heights above it

    bool is_orthographic() const { return view_height > 0; }
};

/// Camera at `origin` looking at `target`. Uses another up vector when `up` is parallel to the view
/// direction.
inline Camera look_at(Vec3 origin, Vec3 target, Vec3 up, float fov_y_rad) {
    Camera c;
    c.origin = origin;
    c.forward = normalize(target - origin);
    Vec3 right = cross(c.forward, up);
    if (length2(right) < 1e-12f * std::max(1e-30f, length2(up))) right = frame_around(c.forward).x;
    c.right = normalize(right);
    c.up = cross(c.right, c.forward);
    c.fov_y_rad = fov_y_rad;
    return c;
}

}  // namespace viscache

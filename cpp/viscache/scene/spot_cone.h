#pragma once
// The cone of a spot light: how its intensity falls off with the angle to its axis.
#include "viscache/math/vec.h"
#include "viscache/sampling/warp.h"

namespace viscache {

/// Factor of the intensity between the inner and the outer angle. t is 1 at the inner angle and 0 at the
/// outer one.
enum class Falloff : uint32_t {
    kNone,       ///< no cone: light in all directions
    kAngle,      ///< t, with t linear in the angle (Mitsuba)
    kQuadratic,  ///< t², with t linear in the cosine (glTF)
    kQuartic,    ///< t⁴, with t linear in the cosine (pbrt-v3)
    kSmooth,     ///< t²(3 − 2t), with t linear in the cosine (pbrt-v4)
};

struct SpotCone {
    Falloff falloff = Falloff::kNone;
    Vec3 axis{};           ///< unit, from the light; zero without a cone
    float cos_inner = 1;   ///< the whole intensity within this angle
    float cos_outer = -1;  ///< no light beyond this angle
    bool operator==(const SpotCone&) const = default;
};

/// Factor of the intensity in the unit direction `away` from the light, in [0, 1].
float spot_factor(const SpotCone& cone, Vec3 away);

/// Integral of `spot_factor` over the sphere, in sr: 4π without a cone.
double spot_integral(const SpotCone& cone);

/// Direction from the light: uniform in the cone, or on the sphere.
inline Vec3 sample_spot(const SpotCone& cone, Vec2 u) {
    if (cone.falloff == Falloff::kNone) return square_to_uniform_sphere(u);
    return frame_around(cone.axis).to_world(square_to_uniform_cone(u, cone.cos_outer));
}
/// Density of `sample_spot` per sr, in the cone.
inline double pdf_spot(const SpotCone& cone) {
    if (cone.falloff == Falloff::kNone) return 0.25 / M_PI;
    return 0.5 / (M_PI * (1 - double(cone.cos_outer)));
}

}  // namespace viscache

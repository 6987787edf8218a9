#pragma once
// The Fresnel reflectance of metals.
#include "viscache/math/vec.h"

namespace viscache {

/// Complex index of refraction η + ik of a metal per colour channel, relative to what is outside.
struct Conductor {
    Rgb eta{}, k{};

    /// False: the material is not described by an index.
    bool is_given() const { return max_component(eta) > 0 || max_component(k) > 0; }
};

/// Unpolarised reflectance of one channel at a cosine in (0, 1].
inline __attribute__((always_inline)) float fresnel_channel(float cos, float eta, float k) {
    const float cos2 = cos * cos, sin2 = 1 - cos2 > 0 ? 1 - cos2 : 0.f;
    const float t = eta * eta - k * k - sin2, root = __builtin_sqrtf(t * t + 4 * eta * eta * k * k);
    const float half = 0.5f * (root + t), a = 2 * cos * __builtin_sqrtf(half > 0 ? half : 0.f);
    const float s = (root + cos2 - a) / (root + cos2 + a);
    const float across = cos2 * root + sin2 * sin2, along = a * sin2;
    return 0.5f * s * (1 + (across - along) / (across + along));
}

inline Rgb fresnel_conductor(const Conductor& metal, float cos) {
    const float c = cos < 1 ? cos : 1.f;
    return {fresnel_channel(c, metal.eta.x, metal.k.x), fresnel_channel(c, metal.eta.y, metal.k.y),
            fresnel_channel(c, metal.eta.z, metal.k.z)};
}

/// What a mirror reflects: `specular`, times F of its metal if it has one (nullptr: none).
inline Rgb mirror_reflectance(Rgb specular, const Conductor* metal, float cos) {
    return metal ? specular * fresnel_conductor(*metal, cos) : specular;
}

}  // namespace viscache

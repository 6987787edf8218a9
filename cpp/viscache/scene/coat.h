#pragma once
// A dielectric layer over a diffuse base: `plastic` and `roughplastic` of Mitsuba 3.
#include <array>

#include "viscache/math/vec.h"
#include "viscache/scene/material.h"

namespace viscache {

/// Roughness of the narrow lobe that stands for the mirror of a smooth coat.
constexpr float kMirrorRoughness = 0.004f;

struct Coat {
    static constexpr int kSteps = 63;
    float eta = 1.5f;
    bool nonlinear = false;
    float internal = 0;  ///< share of the base's light that the layer sends back to the base
    float mean = 1;      ///< cosine-weighted mean of the transmittance T over the hemisphere
    std::array<float, kSteps + 1> transmittance{};  ///< T from outside, at the cosines i / kSteps
};

/// T at a cosine in [0, 1], linear between the steps.
inline __attribute__((always_inline)) float transmitted(const float* transmittance, float cos) {
    const float at = cos * float(Coat::kSteps);
    const int step = int(at), i = step < Coat::kSteps - 1 ? step : Coat::kSteps - 1;
    return transmittance[i] + (at - float(i)) * (transmittance[i + 1] - transmittance[i]);
}

/// Reflectance F of a smooth dielectric for light from outside, cos > 0: `fresnel_dielectric` without
/// branches.
inline __attribute__((always_inline)) float fresnel_outside(float cos, float eta) {
    const float t2 = 1 - (1 - cos * cos) / (eta * eta), t = __builtin_sqrtf(t2 > 0 ? t2 : 0.f);
    const float s = (cos - eta * t) / (cos + eta * t), p = (eta * cos - t) / (eta * cos + t);
    return 0.5f * (s * s + p * p);
}

/// What the base reflects, with all passes between base and layer, but without T of both directions:
/// base / (η² (1 − internal · x)), where x is the base if nonlinear, or else 1.
Rgb coated_base(const Coat& coat, Rgb base);

/// The coat of these parameters. It lives as long as the process: computing one takes milliseconds, and
/// scenes have few.
const Coat& coat_of(CoatKind kind, float eta, float roughness, bool nonlinear);

}  // namespace viscache

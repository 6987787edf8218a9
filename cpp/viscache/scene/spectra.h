#pragma once
// Spectra, black bodies and named media of scene files, to linear sRGB.
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "viscache/math/vec.h"

namespace viscache::loading {

/// (wavelength in nm, value); wavelengths grow strictly.
using Spectrum = std::vector<std::pair<double, double>>;

/// Linear sRGB of a piecewise linear spectrum, 0 outside of its range; a flat spectrum of 1 gives (1, 1, 1).
/// CIE 1931 matching functions by the analytic fit of Wyman, Sloan and Shirley 2013. May be out of gamut.
Rgb spectrum_to_rgb(const Spectrum& spectrum);

/// Spectral radiance of a black body in W/(m² sr nm), as RGB.
Rgb blackbody_rgb(double kelvin);

/// Complex index of refraction, per colour channel.
struct ConductorIor {
    Rgb eta, k;
};
std::optional<ConductorIor> conductor_named(const std::string& name);

/// Index of refraction of a dielectric such as "bk7" or "water".
std::optional<double> ior_named(const std::string& name);

float srgb_to_linear(float encoded);

}  // namespace viscache::loading

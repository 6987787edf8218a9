#pragma once
// Converts spectra, black bodies and named media of scene files to linear sRGB.
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "viscache/math/vec.h"

namespace viscache::loading {

/// Pairs (wavelength in nm, value); wavelengths increase strictly.
using Spectrum = std::vector<std::pair<double, double>>;

/// Linear sRGB of a piecewise linear spectrum that is 0 outside its range. A flat spectrum of 1 gives (1, 1,
/// 1). Uses the analytic fit of the CIE 1931 matching functions by Wyman, Sloan and Shirley 2013. The result
/// may be out of gamut.
Rgb spectrum_to_rgb(const Spectrum& spectrum);

/// Spectral radiance of a black body in W/(m² sr nm), as RGB.
Rgb blackbody_rgb(double kelvin);

/// Complex index of refraction for each colour channel.
struct ConductorIor {
    Rgb eta, k;
};
std::optional<ConductorIor> conductor_named(const std::string& name);

/// Index of refraction of a dielectric such as "bk7" or "water".
std::optional<double> ior_named(const std::string& name);

float srgb_to_linear(float encoded);

}  // namespace viscache::loading

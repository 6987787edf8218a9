#pragma once
// Converts spectra, black bodies and named media of scene files to linear sRGB.
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "viscache/math/vec.h"
#include "viscache/scene/conductor.h"

namespace viscache::loading {

/// Pairs (wavelength in nm, value); wavelengths increase strictly.
using Spectrum = std::vector<std::pair<double, double>>;

/// What a spectrum describes, and so the white that it is relative to.
enum class SpectrumOf {
    kLight,       ///< no white balance: equal energy of 1 has luminance 1 and is reddish
    kReflectance  ///< under daylight D65: a flat spectrum of 1 is (1, 1, 1)
};

/// Linear sRGB of a piecewise linear spectrum that is 0 outside its range, through the matching functions of
/// the CIE 1931 observer. Mitsuba 3 converts so in its RGB variants. The result may be out of gamut.
Rgb spectrum_to_rgb(const Spectrum& spectrum, SpectrumOf what);

/// Linear sRGB of light of equal energy at all wavelengths.
Rgb equal_energy_rgb(double value);

/// Spectral radiance of a black body in W/(m² sr nm), as RGB of a light.
Rgb blackbody_rgb(double kelvin);

/// A metal such as "Cu"; "none" is a perfect mirror.
std::optional<Conductor> conductor_named(const std::string& name);

/// Index of refraction of a dielectric such as "bk7" or "water".
std::optional<double> ior_named(const std::string& name);

}  // namespace viscache::loading

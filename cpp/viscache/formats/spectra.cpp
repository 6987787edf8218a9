#include "viscache/formats/spectra.h"

#include <algorithm>
#include <array>

#include "viscache/formats/cie_tables.h"
#include "viscache/formats/loading.h"

namespace viscache::loading {

namespace {

/// Value at `nm` of a table that starts at the first wavelength of the matching functions.
template <class Entry>
double interpolated(double nm, int step, Entry entry) {
    const double at = (nm - kMatchingFirst) / step;
    const int below = std::min(int(at), (kMatchingLast - kMatchingFirst) / step - 1);
    return entry(below) + (entry(below + 1) - entry(below)) * (at - below);
}

struct Xyz {
    double x = 0, y = 0, z = 0;
};

/// Sums value(nm) times the matching functions at the wavelengths that Mitsuba 3 takes. A spectrum may end
/// anywhere between them.
template <class Value>
Xyz integrate(Value value) {
    Xyz s;
    constexpr int kSteps = 1000;
    for (int i = 0; i < kSteps; ++i) {
        const double nm = kMatchingFirst + (kMatchingLast - kMatchingFirst) * double(i) / (kSteps - 1);
        const double v = value(nm);
        if (v == 0) continue;
        double m[3];
        for (int c = 0; c < 3; ++c)
            m[c] = interpolated(nm, kMatchingStep, [&](int i) { return kMatching[i][c]; });
        s.x += v * m[0];
        s.y += v * m[1];
        s.z += v * m[2];
    }
    return s;
}

double daylight(double nm) {
    return interpolated(nm, kDaylightStep, [](int i) { return kDaylight[i]; });
}

/// Linear sRGB (IEC 61966-2-1), in double precision.
std::array<double, 3> srgb(const Xyz& c) {
    return {3.2404542 * c.x - 1.5371385 * c.y - 0.4985314 * c.z,
            -0.9692660 * c.x + 1.8760108 * c.y + 0.0415560 * c.z,
            0.0556434 * c.x - 0.2040259 * c.y + 1.0572252 * c.z};
}

template <class Value>
Rgb light_rgb(Value value) {
    static const double equal_energy = integrate([](double) { return 1.0; }).y;
    const auto rgb = srgb(integrate(value));
    return {float(rgb[0] / equal_energy), float(rgb[1] / equal_energy), float(rgb[2] / equal_energy)};
}

template <class Value>
Rgb reflectance_rgb(Value value) {
    static const auto white = srgb(integrate(daylight));
    const auto rgb = srgb(integrate([&](double nm) { return value(nm) * daylight(nm); }));
    return {float(rgb[0] / white[0]), float(rgb[1] / white[1]), float(rgb[2] / white[2])};
}

}  // namespace

Rgb spectrum_to_rgb(const Spectrum& spectrum, SpectrumOf what) {
    const auto value = [&](double nm) {
        if (spectrum.empty() || nm < spectrum.front().first || nm > spectrum.back().first) return 0.0;
        const auto above = std::lower_bound(spectrum.begin(), spectrum.end(), nm,
                                            [](const auto& sample, double x) { return sample.first < x; });
        if (above == spectrum.begin()) return above->second;
        const auto below = above - 1;
        const double t = (nm - below->first) / (above->first - below->first);
        return below->second + t * (above->second - below->second);
    };
    return what == SpectrumOf::kLight ? light_rgb(value) : reflectance_rgb(value);
}

Rgb equal_energy_rgb(double value) {
    return light_rgb([&](double) { return value; });
}

Rgb blackbody_rgb(double kelvin) {
    constexpr double h = 6.62607015e-34, c = 299792458.0, k = 1.380649e-23;
    return light_rgb([&](double nm) {
        const double m = nm * 1e-9;
        return 2 * h * c * c / (std::pow(m, 5) * std::expm1(h * c / (m * k * kelvin))) * 1e-9;
    });
}

std::optional<double> ior_named(const std::string& name) {
    static const std::pair<const char*, double> table[] = {
        {"vacuum", 1.0},      {"helium", 1.000036},        {"hydrogen", 1.000132},
        {"air", 1.000277},    {"carbon dioxide", 1.00045}, {"water", 1.3330},
        {"acetone", 1.36},    {"ethanol", 1.361},          {"carbon tetrachloride", 1.461},
        {"glycerol", 1.4729}, {"benzene", 1.501},          {"silicone oil", 1.52045},
        {"bromine", 1.661},   {"water ice", 1.31},         {"fused quartz", 1.458},
        {"pyrex", 1.470},     {"acrylic glass", 1.49},     {"polypropylene", 1.49},
        {"bk7", 1.5046},      {"sodium chloride", 1.544},  {"amber", 1.55},
        {"pet", 1.5750},      {"diamond", 2.419},
    };
    for (const auto& [known, ior] : table)
        if (name == known) return ior;
    return {};
}

}  // namespace viscache::loading

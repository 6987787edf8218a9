#include "viscache/scene/spectra.h"

#include <algorithm>

#include "viscache/scene/loading.h"

namespace viscache::loading {

namespace {

double lobe(double nm, double peak, double below, double above) {
    const double t = (nm - peak) / (nm < peak ? below : above);
    return std::exp(-0.5 * t * t);
}

struct Xyz {
    double x, y, z;
};

/// Multi-lobe fit (Wyman et al. 2013, Table 1).
Xyz matching(double nm) {
    return {1.056 * lobe(nm, 599.8, 37.9, 31.0) + 0.362 * lobe(nm, 442.0, 16.0, 26.7) -
                0.065 * lobe(nm, 501.1, 20.4, 26.2),
            0.821 * lobe(nm, 568.8, 46.9, 40.5) + 0.286 * lobe(nm, 530.9, 16.3, 31.1),
            1.217 * lobe(nm, 437.0, 11.8, 36.0) + 0.681 * lobe(nm, 459.0, 26.0, 13.8)};
}

/// Sums over 360-830 nm in steps of 1 nm and converts to linear sRGB primaries, without normalisation.
template <class Value>
void integrate(Value value, double rgb[3]) {
    Xyz s{0, 0, 0};
    for (int nm = 360; nm <= 830; ++nm) {
        const double v = value(double(nm));
        const Xyz m = matching(nm);
        s.x += v * m.x;
        s.y += v * m.y;
        s.z += v * m.z;
    }
    rgb[0] = 3.2404542 * s.x - 1.5371385 * s.y - 0.4985314 * s.z;
    rgb[1] = -0.9692660 * s.x + 1.8760108 * s.y + 0.0415560 * s.z;
    rgb[2] = 0.0556434 * s.x - 0.2040259 * s.y + 1.0572252 * s.z;
}

template <class Value>
Rgb to_rgb(Value value) {
    double rgb[3], white[3];
    integrate(value, rgb);
    integrate([](double) { return 1.0; }, white);
    return {float(rgb[0] / white[0]), float(rgb[1] / white[1]), float(rgb[2] / white[2])};
}

}  // namespace

Rgb spectrum_to_rgb(const Spectrum& spectrum) {
    return to_rgb([&](double nm) {
        if (spectrum.empty() || nm < spectrum.front().first || nm > spectrum.back().first) return 0.0;
        const auto above = std::lower_bound(spectrum.begin(), spectrum.end(), nm,
                                            [](const auto& sample, double x) { return sample.first < x; });
        if (above == spectrum.begin()) return above->second;
        const auto below = above - 1;
        const double t = (nm - below->first) / (above->first - below->first);
        return below->second + t * (above->second - below->second);
    });
}

Rgb blackbody_rgb(double kelvin) {
    constexpr double h = 6.62607015e-34, c = 299792458.0, k = 1.380649e-23;
    return to_rgb([&](double nm) {
        const double m = nm * 1e-9;
        return 2 * h * c * c / (std::pow(m, 5) * std::expm1(h * c / (m * k * kelvin))) * 1e-9;
    });
}

std::optional<ConductorIor> conductor_named(const std::string& name) {
    // Measured metals as RGB, as in the scene data of Tungsten and Mitsuba.
    static const std::pair<const char*, ConductorIor> table[] = {
        {"Ag", {{0.1552f, 0.1167f, 0.1383f}, {4.8283f, 3.1222f, 2.1470f}}},
        {"Al", {{1.6574f, 0.8803f, 0.5212f}, {9.2238f, 6.2695f, 4.8370f}}},
        {"Au", {{0.1431f, 0.3749f, 1.4424f}, {3.9831f, 2.3857f, 1.6032f}}},
        {"Cr", {{4.3696f, 2.9167f, 1.6547f}, {5.2064f, 4.2313f, 3.7549f}}},
        {"Cu", {{0.2004f, 0.9240f, 1.1022f}, {3.9129f, 2.4528f, 2.1421f}}},
        {"none", {{0, 0, 0}, {1, 1, 1}}},
    };
    for (const auto& [known, ior] : table)
        if (name == known) return ior;
    return {};
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

float srgb_to_linear(float c) { return c <= 0.04045f ? c / 12.92f : std::pow((c + 0.055f) / 1.055f, 2.4f); }

}  // namespace viscache::loading

#include "viscache/scene/sky.h"

#include <chrono>
#include <cmath>
#include <sstream>

namespace viscache {

namespace {

constexpr int kTurbidities = 10, kAlbedos = 2, kControls = 6, kCoefficients = 9, kElevations = 30;

constexpr double kDistribution[kTurbidities][kAlbedos][kControls][3][kCoefficients] = {
#include "viscache/scene/hosek_sky.inc"
};
constexpr double kMean[kTurbidities][kAlbedos][kControls][3] = {
#include "viscache/scene/hosek_sky_mean.inc"
};
constexpr float kSun[kTurbidities][kElevations][3] = {
#include "viscache/scene/hosek_sun.inc"
};
constexpr double kPerNanometre = 1 / 106.7502593994140625;  // one over the integral of CIE y over nm

/// Bernstein polynomials of degree five: weights of the control points (Hosek and Wilkie 2012, Eq. 11).
void control_weights(double elevation, double weights[kControls]) {
    // The cube root puts more control points at low suns, where the sky changes most
    const double x = std::cbrt(2 / M_PI * elevation);
    constexpr double binomial[kControls] = {1, 5, 10, 10, 5, 1};
    for (int k = 0; k < kControls; ++k)
        weights[k] = binomial[k] * std::pow(x, k) * std::pow(1 - x, kControls - 1 - k);
}

/// Index below `x` in a table of `count` entries, and the share of the next entry.
std::pair<int, double> between(double x, int count) {
    const double inside = std::clamp(x, 0.0, double(count - 1));
    const int below = std::min(int(inside), count - 2);
    // The last interval also serves the end itself
    return {below, inside - below};
}

/// Squares of floats neither overflow nor vanish here. std::hypot would bind wheels to glibc 2.35.
double horizontal_length(Vec3 d) { return std::sqrt(double(d.x) * double(d.x) + double(d.z) * double(d.z)); }

void check_sky(const SkySettings& s) {
    std::ostringstream text;
    if (!(s.turbidity >= 1 && s.turbidity <= 10))
        text << "turbidity must be in [1, 10], got " << s.turbidity;
    else if (!(std::min({s.albedo.x, s.albedo.y, s.albedo.z}) >= 0 && max_component(s.albedo) <= 1))
        text << "the albedo of the ground must be in [0, 1]";
    else if (!(s.stretch >= 1 && s.stretch <= 2))
        text << "stretch must be in [1, 2], got " << s.stretch;
    else if (!(std::fabs(length(s.to_sun) - 1) < 1e-3f))
        text << "the direction to the sun must not be zero or non-finite";
    if (const std::string what = text.str(); !what.empty()) throw SceneError(what);
}

}  // namespace

ClearSky::ClearSky(const SkySettings& settings) : settings_(settings) {
    check_sky(settings);
    // The model knows the sun's height alone: the azimuth turns the whole sky
    elevation_ = std::asin(std::clamp(double(settings.to_sun.y), -1.0, 1.0));
    double weights[kControls];
    control_weights(std::max(0.0, elevation_), weights);
    // Four corners of the table, between two turbidities and two albedos
    const auto [haze, more_haze] = between(settings.turbidity - 1, kTurbidities);
    for (int channel = 0; channel < 3; ++channel) {
        mean_[channel] = 0;
        std::fill_n(coefficients_[channel], kCoefficients, 0.0);
        for (int corner = 0; corner < 4; ++corner) {
            const int t = haze + corner / 2, a = corner % 2;
            const double albedo = double(settings.albedo[channel]);
            const double share = (corner / 2 ? more_haze : 1 - more_haze) * (a ? albedo : 1 - albedo);
            for (int k = 0; k < kControls; ++k) {
                mean_[channel] += share * weights[k] * kMean[t][a][k][channel] * kPerNanometre;
                for (int i = 0; i < kCoefficients; ++i)
                    coefficients_[channel][i] += share * weights[k] * kDistribution[t][a][k][channel][i];
            }
        }
    }
}

ClearSky::Ring ClearSky::ring(double zenith) const {
    Ring r;
    // Stretched skies look up a smaller angle, so that the model's horizon comes to lie lower
    const double angle = zenith / settings_.stretch;
    r.cos_zenith = std::cos(angle);
    r.sin_zenith = std::sin(angle);
    // Below the horizon of the model: black, or the horizon's colour continued
    if (r.cos_zenith <= 0) {
        r.is_black = !settings_.extend;
        r.cos_zenith = 0;
        r.sin_zenith = 1;
    }
    r.is_black = r.is_black || elevation_ < 0;
    for (int k = 0; k < 3; ++k) {
        const double* c = coefficients_[k];
        r.factor[k] = mean_[k] * (1 + c[0] * std::exp(c[1] / (r.cos_zenith + 0.01)));
        r.summand[k] = c[2] + c[7] * std::sqrt(r.cos_zenith);
    }
    return r;
}

/// Hosek and Wilkie 2012, Eq. 8.
Rgb ClearSky::radiance(const Ring& r, double cos_sun) const {
    const double gamma = std::acos(std::clamp(cos_sun, -1.0, 1.0)), cos_2 = cos_sun * cos_sun;
    float rgb[3];
    for (int k = 0; k < 3; ++k) {
        const double* c = coefficients_[k];
        // x^1.5 as x·√x, which is cheaper than a power
        const double near = 1 + c[8] * c[8] - 2 * c[8] * cos_sun;
        const double mie = (1 + cos_2) / (near * std::sqrt(near));
        const double around_sun = c[3] * std::exp(c[4] * gamma) + c[5] * cos_2 + c[6] * mie;
        rgb[k] = float(std::max(0.0, r.factor[k] * (r.summand[k] + around_sun)));
    }
    return {rgb[0], rgb[1], rgb[2]};
}

Rgb ClearSky::radiance(Vec3 d) const {
    const Ring r = ring(std::acos(std::clamp(double(d.y), -1.0, 1.0)));
    if (r.is_black) return {};
    const double flat = horizontal_length(d), turned = flat > 0 ? r.sin_zenith / flat : 0;
    const Vec3 sun = settings_.to_sun;
    // The angle to the sun in the stretched sky: the horizontal part has another length there
    return radiance(r, turned * (double(d.x) * sun.x + double(d.z) * sun.z) + r.cos_zenith * sun.y);
}

Rgb ClearSky::sun_irradiance() const {
    if (elevation_ < 0) return {};
    // The table starts at an elevation of 2° and has steps of 3°. The lowest sun is out of gamut: negative
    // blue becomes 0
    const auto [haze, more_haze] = between(settings_.turbidity - 1, kTurbidities);
    const auto [low, higher] = between((elevation_ * 180 / M_PI - 2) / 3, kElevations);
    double rgb[3] = {};
    for (int corner = 0; corner < 4; ++corner) {
        const float* entry = kSun[haze + corner / 2][low + corner % 2];
        const double share = (corner / 2 ? more_haze : 1 - more_haze) * (corner % 2 ? higher : 1 - higher);
        for (int c = 0; c < 3; ++c) rgb[c] += share * double(entry[c]);
    }
    return max({0, 0, 0}, {float(rgb[0]), float(rgb[1]), float(rgb[2])});
}

Vec3 ClearSky::to_sun() const {
    const Vec3 sun = settings_.to_sun;
    const double angle = (M_PI / 2 - elevation_) * settings_.stretch;
    const double flat = horizontal_length(sun), out = flat > 0 ? std::sin(angle) / flat : 0;
    return settings_.stretch == 1
               ? sun
               : normalize({float(sun.x * out), float(std::cos(angle)), float(sun.z * out)});
}

Image ClearSky::image(int width) const {
    if (width < 2 || width > 1 << 14 || width % 2)
        throw SceneError("the width of a sky's image must be even and in [2, 16384], got " +
                         std::to_string(width));
    Image out;
    out.width = width;
    out.height = width / 2;
    out.channels = 3;
    out.pixels.resize(size_t(out.width) * size_t(out.height) * 3);
    // Four points of a pixel lie on two rings and two meridians. Column: u = atan2(x, −z)/2π
    const double step = M_PI / out.height;
    const Vec3 sun = settings_.to_sun;
    std::vector<double> along_sun(2 * size_t(out.width));  // of the meridians' directions
    for (size_t i = 0; i < along_sun.size(); ++i) {
        const double phi = (double(i) + 0.5) * step / 2;
        along_sun[i] = std::sin(phi) * sun.x - std::cos(phi) * sun.z;
    }
    // Ring by ring, since most of the formula depends on the zenith angle alone
    for (int y = 0; y < 2 * out.height; ++y) {
        const Ring r = ring((y + 0.5) * step / 2);
        if (r.is_black) continue;
        float* pixel = &out.pixels[size_t(y / 2) * size_t(out.width) * 3];
        for (size_t i = 0; i < along_sun.size(); ++i) {
            const Rgb found = radiance(r, r.sin_zenith * along_sun[i] + r.cos_zenith * sun.y) / 4;
            float* to = pixel + i / 2 * 3;
            to[0] += found.x;
            to[1] += found.y;
            to[2] += found.z;
        }
    }
    return out;
}

Vec3 sun_direction(const SunTime& t) {
    using namespace std::chrono;
    const year_month_day date{year{t.year}, month{unsigned(t.month)}, day{unsigned(t.day)}};
    if (!date.ok() || t.month < 1 || t.day < 1)
        throw SceneError("a date must exist, got " + std::to_string(t.year) + "-" + std::to_string(t.month) +
                         "-" + std::to_string(t.day));
    const double universal = t.hour - t.timezone;
    const auto midnights = sys_days{date} - sys_days{year{2000} / January / 1};
    const double days = double(midnights.count()) - 0.5 + universal / 24;  // since noon of 1 January 2000
    // Ecliptic longitude and obliquity
    const double node = 2.1429 - 0.0010394594 * days, anomaly = 6.2400600 + 0.0172019699 * days;
    const double longitude = 4.8950630 + 0.017202791698 * days + 0.03341607 * std::sin(anomaly) +
                             0.00034894 * std::sin(2 * anomaly) - 0.0001134 - 0.0000203 * std::sin(node);
    const double obliquity = 0.4090928 - 6.2140e-9 * days + 0.0000396 * std::cos(node);
    // Right ascension and declination
    const double ascension = std::atan2(std::cos(obliquity) * std::sin(longitude), std::cos(longitude));
    const double declination = std::asin(std::sin(obliquity) * std::sin(longitude));
    // Zenith angle and azimuth of the observer
    const double sidereal = 6.6974243242 + 0.0657098283 * days + universal;
    const double hour_angle = (sidereal * 15 + t.longitude) * M_PI / 180 - ascension;
    const double latitude = t.latitude * M_PI / 180;
    double zenith = std::acos(std::cos(latitude) * std::cos(hour_angle) * std::cos(declination) +
                              std::sin(declination) * std::sin(latitude));
    const double azimuth = std::atan2(-std::sin(hour_angle), std::tan(declination) * std::cos(latitude) -
                                                                 std::sin(latitude) * std::cos(hour_angle));
    constexpr double parallax = 6371.01 / 149597890;  // mean radius of the Earth in astronomical units
    zenith += parallax * std::sin(zenith);
    return {float(std::sin(zenith) * std::sin(azimuth)), float(std::cos(zenith)),
            float(std::sin(zenith) * std::cos(azimuth))};
}

}  // namespace viscache

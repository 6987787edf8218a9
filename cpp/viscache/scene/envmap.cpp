#include "viscache/scene/envmap.h"

#include <bit>
#include <sstream>

#include "viscache/math/octahedral.h"
#include "viscache/math/parallel.h"

namespace viscache {

namespace {

constexpr int kMaxResolution = 2048;
constexpr double kPowerTolerance = 0.02;

/// Bilinear in the lat-long image: columns wrap around, rows stop at the poles.
Rgb lookup(const Image& image, Vec3 d) {
    float u = std::atan2(d.x, -d.z) * (0.5f / kPi);
    u -= std::floor(u);
    const float v = std::acos(std::clamp(d.y, -1.f, 1.f)) * (1 / kPi);
    const float x = u * image.width - 0.5f, y = v * image.height - 0.5f;
    const int x0 = int(std::floor(x)), y0 = int(std::floor(y));
    const float fx = x - x0, fy = y - y0;
    Rgb sum;
    for (int dy = 0; dy < 2; ++dy)
        for (int dx = 0; dx < 2; ++dx) {
            const int xi = (x0 + dx + image.width) % image.width, yi = std::clamp(y0 + dy, 0, image.height - 1);
            const float* p = &image.pixels[(size_t(yi) * image.width + xi) * image.channels];
            const Rgb texel = image.channels >= 3 ? Rgb{p[0], p[1], p[2]} : Rgb{p[0], p[0], p[0]};
            sum += texel * ((dx ? fx : 1 - fx) * (dy ? fy : 1 - fy));
        }
    return sum;
}

void check_pixels(const Image& image) {
    for (size_t i = 0; i < image.pixels.size(); ++i)
        if (!(image.pixels[i] >= 0) || !std::isfinite(image.pixels[i])) {
            std::ostringstream s;
            s << "environment image '" << image.path << "' must be finite and >= 0, pixel (row "
              << i / image.channels / image.width << ", column " << i / image.channels % image.width << ") is "
              << image.pixels[i];
            throw SceneError(s.str());
        }
}

/// Integral of the image's luminance over the sphere: rows weighted by their exact solid angle.
double source_power(const Image& image, Rgb scale) {
    double power = 0;
    for (int y = 0; y < image.height; ++y) {
        const double solid = 2 * M_PI / image.width *
                             (std::cos(M_PI * y / image.height) - std::cos(M_PI * (y + 1) / image.height));
        double row = 0;
        for (int x = 0; x < image.width; ++x) {
            const float* p = &image.pixels[(size_t(y) * image.width + x) * image.channels];
            row += luminance((image.channels >= 3 ? Rgb{p[0], p[1], p[2]} : Rgb{p[0], p[0], p[0]}) * scale);
        }
        power += row * solid;
    }
    return power;
}

/// Inverse of a rotation (with scale, its direction part is what counts).
Vec3 to_map(const Affine& to_world, Vec3 w) {
    // normal() applies the inverse transpose: for rotations the same matrix, so use the transpose by rows
    const auto& m = to_world.m;
    Vec3 d{float(m[0][0] * w.x + m[1][0] * w.y + m[2][0] * w.z), float(m[0][1] * w.x + m[1][1] * w.y + m[2][1] * w.z),
           float(m[0][2] * w.x + m[1][2] * w.y + m[2][2] * w.z)};
    return normalize(d);
}

}  // namespace

EnvironmentMap EnvironmentMap::constant(Rgb radiance) {
    EnvironmentMap map;
    map.pixels_ = {radiance};
    map.build_tables();
    return map;
}

EnvironmentMap EnvironmentMap::from_latlong(const Image& image, Rgb scale, const Affine& to_world, int resolution) {
    check_pixels(image);
    EnvironmentMap map;
    // 4π/N² ≤ the solid angle of a pixel at the equator
    const double wish = resolution > 0 ? resolution : std::sqrt(2.0 * image.width * image.height / M_PI);
    const int n = map.resolution_ = std::min(kMaxResolution, int(std::bit_ceil(uint32_t(std::max(wish, 2.0)))));
    const int sub = n <= 1024 ? 4 : 2;  // samples per axis of a texel
    map.pixels_.resize(size_t(n) * n);
    parallel_for(size_t(n), 0, [&](size_t y, int) {
        for (int x = 0; x < n; ++x) {
            Rgb sum;
            for (int i = 0; i < sub * sub; ++i) {
                const Vec2 p{(x + (i % sub + 0.5f) / sub) / n, (y + (i / sub + 0.5f) / sub) / n};
                sum += lookup(image, to_map(to_world, equal_area_to_direction(p)));
            }
            map.pixels_[y * n + x] = sum * scale / float(sub * sub);
        }
    });
    map.build_tables();
    const double wanted = source_power(image, scale);
    map.power_ratio_ = map.total_power_ / wanted;
    if (!(std::fabs(map.power_ratio_ - 1) <= kPowerTolerance)) {
        std::ostringstream s;
        s << "environment image '" << image.path << "': resampling must keep the power within 2 %, got a factor of "
          << map.power_ratio_;
        throw SceneError(s.str());
    }
    for (Rgb& p : map.pixels_) p = p * float(1 / map.power_ratio_);
    map.build_tables();
    return map;
}

void EnvironmentMap::build_tables() {
    std::vector<double> weight(pixels_.size());
    double sum = 0;
    for (size_t i = 0; i < pixels_.size(); ++i) sum += weight[i] = luminance(pixels_[i]);
    if (!(sum > 0)) throw SceneError("the environment must not be black everywhere");
    total_power_ = sum * 4 * M_PI / double(pixels_.size());
    // A texel of pure blue has little luminance but must keep a chance: weights follow luminance, floored by the largest channel
    for (size_t i = 0; i < pixels_.size(); ++i) weight[i] = std::max(weight[i], 0.1 * max_component(pixels_[i]));
    if (resolution_ > 1) choice_ = Distribution1D(weight);
}

size_t EnvironmentMap::texel(Vec3 wi) const {
    const Vec2 p = direction_to_equal_area(wi);
    const int x = std::min(int(p.x * resolution_), resolution_ - 1), y = std::min(int(p.y * resolution_), resolution_ - 1);
    return size_t(y) * resolution_ + x;
}

EnvironmentMap::Sample EnvironmentMap::sample(Vec2 u) const {
    if (is_constant()) return {equal_area_to_direction(u), pixels_[0], 1 / (4 * kPi)};
    const auto pick = choice_.sample(u.x);
    const Vec2 p{(float(pick.index % resolution_) + pick.u) / resolution_, (float(pick.index / resolution_) + u.y) / resolution_};
    const Vec3 wi = equal_area_to_direction(p);
    // Rounding at a texel's edge may lead next door: report what `eval` and `pdf` say there
    const size_t at = texel(wi);
    return {wi, pixels_[at], float(choice_.pmf(at) * double(pixels_.size()) / (4 * M_PI))};
}

float EnvironmentMap::pdf(Vec3 wi) const {
    if (is_constant()) return 1 / (4 * kPi);
    return float(choice_.pmf(texel(wi)) * double(pixels_.size()) / (4 * M_PI));
}

}  // namespace viscache

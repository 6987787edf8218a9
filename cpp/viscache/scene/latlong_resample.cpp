#include "viscache/scene/latlong_resample.h"

#include <bit>
#include <limits>
#include <sstream>
#include <type_traits>

#include "viscache/math/parallel.h"
#include "viscache/scene/latlong_batch.h"

namespace viscache {

namespace {

constexpr double kPowerTolerance = 0.02;
constexpr size_t kMaxPixels = size_t(1) << 27;  // of the image: the resampling takes seconds then
constexpr int kMaxResolution = 4096;
constexpr int kMaxAutomatic = 2048;  // at most 63 MB of texels and tables, unless a larger map is requested

template <class... Parts>
[[noreturn]] void fail_latlong(const Image& image, const Parts&... parts) {
    std::ostringstream s;
    if (!image.where.empty()) s << image.where << ": ";
    s << "environment image '" << image.path << "' ";
    (s << ... << parts);
    throw SceneError(s.str());
}

/// Pixels of three floats.
struct FloatRgb {
    const float* values;
    int last;  ///< index of the last pixel
    Rgb operator()(size_t i) const { return {values[3 * i], values[3 * i + 1], values[3 * i + 2]}; }
};

/// Calls work(pixel), where pixel(i) is the colour of pixel i in row-major order.
template <class Work>
auto with_pixels(const Image& image, Work work) {
    const size_t n = size_t(image.channels);
    if (image.bytes.empty() && n == 3) return work(FloatRgb{image.pixels.data(), int(image.size() / 3) - 1});
    const auto rgb = [n](size_t i, auto value) {
        const size_t first = i * n;
        return n >= 3 ? Rgb{value(first), value(first + 1), value(first + 2)}
                      : Rgb{value(first), value(first), value(first)};
    };
    if (image.bytes.empty())
        return work(
            [=, p = image.pixels.data()](size_t i) { return rgb(i, [p](size_t k) { return p[k]; }); });
    return work([=, p = image.bytes.data(), v = image.values_of(0)](size_t i) {
        return rgb(i, [p, v](size_t k) { return v[p[k]]; });
    });
}

/// Whether all values are so small and positive that none needs a look of its own. Without branches: the
/// compiler vectorises the loop.
bool far_from_unusable(const Image& image, Rgb scale) {
    const float limit = std::numeric_limits<float>::max() / (2 * std::max(1.f, max_component(scale)));
    int outside = !usable_radiance(scale);
    for (float v : image.pixels) outside |= !(v >= 0) | !(v <= limit);
    return !outside;
}

void check_radiance(const Image& image, Rgb scale) {
    if (far_from_unusable(image, scale)) return;
    with_pixels(image, [&](auto pixel) {
        const size_t width = size_t(image.width);
        for (size_t i = 0; i < width * size_t(image.height); ++i)
            if (const Rgb c = pixel(i); !usable_radiance(c * scale))
                fail_latlong(image, "must be finite and >= 0, got (", c.x, ", ", c.y, ", ", c.z,
                             ") times scale (", scale.x, ", ", scale.y, ", ", scale.z, ") in row ", i / width,
                             ", column ", i % width);
    });
}

void check_latlong(const Image& image, Rgb scale, const Affine& to_world, int resolution) {
    const size_t expected =
        size_t(std::max(0, image.width)) * std::max(0, image.height) * std::max(0, image.channels);
    if (expected == 0 || image.size() != expected)
        fail_latlong(image, "must have pixels, got ", image.width, " x ", image.height, " x ",
                     image.channels);
    if (size_t(image.width) * image.height > kMaxPixels)
        fail_latlong(image, "has ", image.width, " x ", image.height,
                     " pixels; skies have at most 2^27 (16384 x 8192): scale it down");
    check_radiance(image, scale);
    if (resolution != 0 &&
        (resolution < 2 || resolution > kMaxResolution || !std::has_single_bit(unsigned(resolution))))
        fail_latlong(image, ": resolution must be 0 or a power of two in [2, ", kMaxResolution, "], got ",
                     resolution);
    // A rotation, possibly with a uniform scale: orthogonal columns of equal length
    const auto& m = to_world.m;
    double gram[3][3], size = 0;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) gram[i][j] = m[0][i] * m[0][j] + m[1][i] * m[1][j] + m[2][i] * m[2][j];
    size = (gram[0][0] + gram[1][1] + gram[2][2]) / 3;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            if (!(size > 0) || !(std::abs(gram[i][j] - (i == j ? size : 0)) <= 1e-3 * size))
                fail_latlong(image, ": to_world must be a rotation, got columns with dot product ",
                             gram[i][j], " (", i, ", ", j, ")");
}

/// Look-ups along a part of a row of texels.
struct LookUps {
    static constexpr size_t kMost = BilinearPlaces::kMost;
    float u[kMost], v[kMost];
    BilinearPlaces places;
    ColorLanes sums[kMost];  ///< by texel

    /// Adds to each of the first `texels` sums the colours of the next `sub` places.
    template <class Pixel>
    void add_bilinear(const Image& image, const Pixel& pixel, size_t texels, size_t sub) {
        bilinear_places({u, texels * sub}, {v, texels * sub}, image.width, image.height, places);
        if constexpr (std::is_same_v<Pixel, FloatRgb>)
            if (places.greatest < pixel.last) return sum_bilinear(pixel.values, places, sub, {sums, texels});
        for (size_t x = 0, k = 0; x < texels; ++x)
            for (size_t end = k + sub; k < end; ++k)
                sums[x] += bilinear(places, k, [&](int i) { return lanes(pixel(size_t(i))); });
    }
    template <class Pixel>
    void add_nearest(const Image& image, const Pixel& pixel, size_t texels, size_t sub) {
        for (size_t x = 0, k = 0; x < texels; ++x)
            for (size_t end = k + sub; k < end; ++k) {
                const int row = std::min(int(v[k] * float(image.height)), image.height - 1);
                const int column = std::min(int(u[k] * float(image.width)), image.width - 1);
                sums[x] += lanes(pixel(size_t(row) * size_t(image.width) + size_t(column)));
            }
    }
    static ColorLanes lanes(Rgb c) { return ColorLanes{c.x, c.y, c.z, 0}; }
};

/// n × n texels, each the mean of sub × sub look-ups.
OctahedralTexels resample(const Image& image, Rgb scale, const Affine& to_world, int n, int sub, bool smooth,
                          int threads) {
    const LatLongTurn turn(to_world);
    const Rgb weight = scale / float(sub * sub);
    const float step = 1 / (float(n) * float(sub));
    const size_t side = size_t(n), each = size_t(sub), stride = std::max<size_t>(1, LookUps::kMost / each);
    OctahedralTexels texels(n);
    with_pixels(image, [&](auto pixel) {
        parallel_for(side, threads, [&](size_t row, int) {
            LookUps l;
            for (size_t first = 0; first < side; first += stride) {
                const size_t count = std::min(stride, side - first);
                std::fill_n(l.sums, count, ColorLanes{});
                for (int j = 0; j < sub; ++j) {
                    const float y = (float(row) * float(sub) + float(j) + 0.5f) * step;
                    latlong_batch(turn, y, float(first * each) + 0.5f, step, count * each, l.u, l.v);
                    if (smooth)
                        l.add_bilinear(image, pixel, count, each);
                    else
                        l.add_nearest(image, pixel, count, each);
                }
                for (size_t x = 0; x < count; ++x) {
                    const Rgb texel = Rgb{l.sums[x][0], l.sums[x][1], l.sums[x][2]} * weight;
                    if (!(texel == Rgb{})) texels[texels.index(first + x, row)] = texel;
                }
            }
        });
    });
    return texels;
}

/// Integral of the image's luminance over the sphere, with rows weighted by their exact solid angle.
double source_power(const Image& image, Rgb scale) {
    return with_pixels(image, [&](auto pixel) {
        double power = 0;
        for (int y = 0; y < image.height; ++y) {
            const double band = std::cos(M_PI * y / image.height) - std::cos(M_PI * (y + 1) / image.height);
            double row = 0;
            for (int x = 0; x < image.width; ++x)
                row += luminance_in_double(pixel(size_t(y) * size_t(image.width) + size_t(x)) * scale);
            power += row * band * 2 * M_PI / image.width;
        }
        return power;
    });
}

}  // namespace

bool usable_radiance(Rgb c) { return is_finite(c) && c.x >= 0 && c.y >= 0 && c.z >= 0; }

ResampledImage resample_latlong(const Image& image, Rgb scale, const Affine& to_world, int resolution,
                                int threads) {
    check_latlong(image, scale, to_world, resolution);
    // Texels no larger than a pixel at the equator: 4π/N² <= its solid angle
    const double same = std::sqrt(2.0 * image.width * image.height / M_PI);
    const int n =
        resolution ? resolution : int(std::bit_ceil(unsigned(std::clamp<double>(same, 2, kMaxAutomatic))));
    // At least two lookups per pixel edge. Where bilinear filtering changes the power (light in a row at a
    // pole), use the nearest pixel
    const int sub = std::clamp(int(std::ceil(2 * same / n)), 2, 64);
    const double wanted = source_power(image, scale);
    ResampledImage map;
    for (const bool smooth : {true, false}) {
        map.texels = resample(image, scale, to_world, n, smooth ? sub : 4 * sub, smooth, threads);
        map.power_ratio = wanted > 0 ? map.texels.power() / wanted : 1;
        if (std::abs(map.power_ratio - 1) <= kPowerTolerance) break;
    }
    if (!(std::abs(map.power_ratio - 1) <= kPowerTolerance))
        fail_latlong(image, ": resampling must keep the power within 2 %, got a factor of ", map.power_ratio);
    const auto correction = float(1 / map.power_ratio);
    map.texels.each([&](size_t i) {
        Rgb& texel = map.texels[i];
        if (!(texel == Rgb{})) texel = texel * correction;
    });
    return map;
}

}  // namespace viscache

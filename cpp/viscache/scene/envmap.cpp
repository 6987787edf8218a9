#include "viscache/scene/envmap.h"

#include <bit>
#include <sstream>

#include "viscache/math/octahedral.h"
#include "viscache/math/parallel.h"
#include "viscache/scene/latlong_batch.h"

namespace viscache {

namespace {

constexpr double kPowerTolerance = 0.02;
constexpr size_t kMaxPixels = size_t(1) << 27;  // of the image: the resampling takes seconds then
constexpr int kMaxResolution = 4096;
constexpr int kMaxAutomatic = 2048;  // at most 200 MB of texels and tables, unless a larger map is requested

template <class... Parts>
[[noreturn]] void fail(const Image& image, const Parts&... parts) {
    std::ostringstream s;
    if (!image.where.empty()) s << image.where << ": ";
    s << "environment image '" << image.path << "' ";
    (s << ... << parts);
    throw SceneError(s.str());
}

/// Calls work(pixel), where pixel(i) is the colour of pixel i in row-major order.
template <class Work>
auto with_pixels(const Image& image, Work work) {
    const size_t n = size_t(image.channels);
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

bool usable(Rgb c) { return is_finite(c) && c.x >= 0 && c.y >= 0 && c.z >= 0; }

void check(const Image& image, Rgb scale, const Affine& to_world, int resolution) {
    const size_t expected =
        size_t(std::max(0, image.width)) * std::max(0, image.height) * std::max(0, image.channels);
    if (expected == 0 || image.size() != expected)
        fail(image, "must have pixels, got ", image.width, " x ", image.height, " x ", image.channels);
    if (size_t(image.width) * image.height > kMaxPixels)
        fail(image, "has ", image.width, " x ", image.height,
             " pixels; skies have at most 2^27 (16384 x 8192): scale it down");
    with_pixels(image, [&](auto pixel) {
        const size_t width = size_t(image.width);
        for (size_t i = 0; i < width * size_t(image.height); ++i)
            if (const Rgb c = pixel(i); !usable(c * scale))
                fail(image, "must be finite and >= 0, got (", c.x, ", ", c.y, ", ", c.z, ") times scale (",
                     scale.x, ", ", scale.y, ", ", scale.z, ") in row ", i / width, ", column ", i % width);
    });
    if (resolution != 0 &&
        (resolution < 2 || resolution > kMaxResolution || !std::has_single_bit(unsigned(resolution))))
        fail(image, ": resolution must be 0 or a power of two in [2, ", kMaxResolution, "], got ",
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
                fail(image, ": to_world must be a rotation, got columns with dot product ", gram[i][j], " (",
                     i, ", ", j, ")");
}

typedef float Lanes __attribute__((vector_size(16)));  ///< a colour and a zero
Lanes lanes_of(Rgb c) { return Lanes{c.x, c.y, c.z, 0}; }

/// Looks up colours at places (u, v) of the lat-long image. Columns wrap around; rows are clamped at the
/// poles.
template <class Pixel>
struct LatLong {
    Pixel pixel;
    int width, height;

    Rgb nearest(float u, float v) const {
        return at(std::min(int(v * float(height)), height - 1), std::min(int(u * float(width)), width - 1));
    }
    Rgb bilinear(float u, float v) const {
        const float x = u * float(width) - 0.5f, y = v * float(height) - 0.5f;
        const int x0 = int(x + 1) - 1, y0 = int(y + 1) - 1;  // x and y are at least -1/2
        const float fx = x - float(x0), fy = y - float(y0), gx = 1 - fx, gy = 1 - fy;
        const int left = x0 < 0 ? width - 1 : x0, right = x0 + 1 == width ? 0 : x0 + 1;
        const int up = std::max(y0, 0), down = std::min(y0 + 1, height - 1);
        const Lanes sum = (lanes(up, left) * gx + lanes(up, right) * fx) * gy +
                          (lanes(down, left) * gx + lanes(down, right) * fx) * fy;
        return {sum[0], sum[1], sum[2]};
    }

private:
    Rgb at(int row, int column) const { return pixel(size_t(row) * size_t(width) + size_t(column)); }
    Lanes lanes(int row, int column) const { return lanes_of(at(row, column)); }
};

/// n × n texels, each the mean of sub × sub lookups.
std::vector<Rgb> resample(const Image& image, Rgb scale, const Affine& to_world, int n, int sub, bool smooth,
                          int threads) {
    const LatLongTurn turn(to_world);
    const Rgb weight = scale / float(sub * sub);
    // Texels of a batch of lookups
    constexpr int kLookups = 512;
    const int stride = std::max(1, kLookups / sub);
    std::vector<Rgb> texels(size_t(n) * size_t(n));
    with_pixels(image, [&](auto pixel) {
        const LatLong<decltype(pixel)> source{pixel, image.width, image.height};
        parallel_for(size_t(n), threads, [&](size_t row, int) {
            const float step = 1 / (float(n) * float(sub));
            std::vector<float> u(size_t(stride) * size_t(sub)), v(u.size());
            for (int first = 0; first < n; first += stride) {
                const std::span batch(&texels[row * size_t(n) + size_t(first)],
                                      size_t(std::min(stride, n - first)));
                for (int j = 0; j < sub; ++j) {
                    const float y = (float(row) * float(sub) + float(j) + 0.5f) * step;
                    latlong_batch(turn, y, float(first * sub) + 0.5f, step, batch.size() * size_t(sub),
                                  u.data(), v.data());
                    for (size_t x = 0, k = 0; x < batch.size(); ++x)
                        for (int i = 0; i < sub; ++i, ++k)
                            batch[x] += smooth ? source.bilinear(u[k], v[k]) : source.nearest(u[k], v[k]);
                }
                for (Rgb& texel : batch) texel = texel * weight;
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

EnvironmentMap EnvironmentMap::constant(Rgb radiance) {
    if (!usable(radiance)) {
        std::ostringstream s;
        s << "environment radiance must be finite and >= 0, got (" << radiance.x << ", " << radiance.y << ", "
          << radiance.z << ")";
        throw SceneError(s.str());
    }
    EnvironmentMap map;
    map.pixels_ = {radiance};
    map.build_tables();
    return map;
}

EnvironmentMap EnvironmentMap::from_latlong(const Image& image, Rgb scale, const Affine& to_world,
                                            int resolution, int threads) {
    check(image, scale, to_world, resolution);
    EnvironmentMap map;
    // Texels no larger than a pixel at the equator: 4π/N² <= its solid angle
    const double same = std::sqrt(2.0 * image.width * image.height / M_PI);
    map.resolution_ =
        resolution ? resolution : int(std::bit_ceil(unsigned(std::clamp<double>(same, 2, kMaxAutomatic))));
    // At least two lookups per pixel edge. Where bilinear filtering changes the power (light in a row at a
    // pole), use the nearest pixel
    const int sub = std::clamp(int(std::ceil(2 * same / map.resolution_)), 2, 64);
    const double wanted = source_power(image, scale);
    for (const bool smooth : {true, false}) {
        map.pixels_ =
            resample(image, scale, to_world, map.resolution_, smooth ? sub : 4 * sub, smooth, threads);
        map.power_ratio_ = wanted > 0 ? map.power() / wanted : 1;
        if (std::abs(map.power_ratio_ - 1) <= kPowerTolerance) break;
    }
    if (!(std::abs(map.power_ratio_ - 1) <= kPowerTolerance))
        fail(image, ": resampling must keep the power within 2 %, got a factor of ", map.power_ratio_);
    for (Rgb& p : map.pixels_) p = p * float(1 / map.power_ratio_);
    map.build_tables();
    return map;
}

double EnvironmentMap::power() const {
    double sum = 0;
    for (const Rgb& p : pixels_) sum += luminance_in_double(p);
    return sum * 4 * M_PI / double(pixels_.size());
}

void EnvironmentMap::build_tables() {
    total_power_ = power();
    if (is_constant() || !(total_power_ > 0)) return;
    const size_t n = size_t(resolution_);
    texels_ =
        Distribution2D(n, n, [&](size_t y, size_t x) { return luminance_in_double(pixels_[y * n + x]); });
}

size_t EnvironmentMap::texel(Vec3 wi) const {
    const Vec2 p = direction_to_equal_area(wi);
    const int n = resolution_, x = std::min(int(p.x * float(n)), n - 1),
              y = std::min(int(p.y * float(n)), n - 1);
    return size_t(y) * n + x;
}

/// Directions are sampled in proportion to luminance, so their density follows from the texel alone.
float EnvironmentMap::density(const Rgb& radiance) const {
    return texels_.empty() ? 1 / (4 * kPi) : float(luminance_in_double(radiance) / total_power_);
}

void EnvironmentMap::look_up(std::span<const Vec3> wi, std::span<Sample> found) const {
    constexpr size_t kBatch = Distribution2D::kBatch;
    const Rgb* place[kBatch];
    for (size_t first = 0; first < wi.size(); first += kBatch) {
        const size_t count = std::min(kBatch, wi.size() - first);
        for (size_t i = 0; i < count; ++i) {
            place[i] = &pixels_[is_constant() ? 0 : texel(wi[first + i])];
            __builtin_prefetch(place[i]);
        }
        for (size_t i = 0; i < count; ++i) found[first + i] = {wi[first + i], *place[i], density(*place[i])};
    }
}

void EnvironmentMap::sample(std::span<const Vec2> u, std::span<Sample> samples) const {
    if (texels_.empty()) {
        for (size_t i = 0; i < u.size(); ++i) {
            const Vec3 wi = equal_area_to_direction(u[i]);
            samples[i] = {wi, eval(wi), density({})};
        }
        return;
    }
    // Stay farther from the texel's edges than the rounding error of a direction, so that `eval(wi)` finds
    // this texel
    const float n = float(resolution_), margin = n * 0x1p-21f;
    const auto place = [&](size_t index, float jitter) {
        return (float(index) + std::clamp(jitter, margin, 1 - margin)) / n;
    };
    Distribution2D::Cell cells[Distribution2D::kBatch];
    for (size_t first = 0; first < u.size(); first += Distribution2D::kBatch) {
        const size_t count = std::min(Distribution2D::kBatch, u.size() - first);
        texels_.sample(count, [&](size_t i) { return std::pair(u[first + i].x, u[first + i].y); }, cells);
        const auto pixel = [&](const Distribution2D::Cell& c) {
            return &pixels_[c.row * size_t(resolution_) + c.column];
        };
        for (size_t i = 0; i < count; ++i) __builtin_prefetch(pixel(cells[i]));
        for (size_t i = 0; i < count; ++i) {
            const auto& c = cells[i];
            const Vec2 p{place(c.column, c.u_column), place(c.row, c.u_row)};
            samples[first + i] = {equal_area_to_direction(p), *pixel(c), density(*pixel(c))};
        }
    }
}

}  // namespace viscache

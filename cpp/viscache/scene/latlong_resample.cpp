#include "viscache/scene/latlong_resample.h"

#include <atomic>
#include <bit>
#include <limits>
#include <sstream>
#include <type_traits>

#include "viscache/math/parallel.h"
#include "viscache/scene/latlong_batch.h"

namespace viscache {

namespace {

constexpr double kPowerTolerance = 0.02;        // of interpolated look-ups
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
    static ColorLanes lanes(Rgb c) { return ColorLanes{c.x, c.y, c.z, 0}; }
};

/// n × n texels, each with sub × sub look-ups.
struct Grid {
    int n, sub;
    double look_up_sr() const { return 4 * M_PI / (double(n) * n * sub * sub); }
};

/// Calls look(l, texels) for every row of look-ups in a part of a row of texels, then done(l, texels, row,
/// first).
template <class Look, class Done>
void visit(const Grid& grid, const Affine& to_world, int threads, Look look, Done done) {
    const LatLongTurn turn(to_world);
    const float step = 1 / (float(grid.n) * float(grid.sub));
    const size_t side = size_t(grid.n), each = size_t(grid.sub),
                 stride = std::max<size_t>(1, LookUps::kMost / each);
    parallel_for(side, threads, [&](size_t row, int) {
        LookUps l;
        for (size_t first = 0; first < side; first += stride) {
            const size_t count = std::min(stride, side - first);
            std::fill_n(l.sums, count, ColorLanes{});
            for (int j = 0; j < grid.sub; ++j) {
                const float y = (float(row) * float(grid.sub) + float(j) + 0.5f) * step;
                latlong_batch(turn, y, float(first * each) + 0.5f, step, count * each, l.u, l.v);
                look(l, count);
            }
            done(l, count, row, first);
        }
    });
}

/// Texels that are the means of their look-ups, from what `look` adds to the sums.
template <class Look>
OctahedralTexels means(const Grid& grid, Rgb scale, const Affine& to_world, int threads, Look look) {
    OctahedralTexels texels(grid.n);
    const Rgb weight = scale / float(grid.sub * grid.sub);
    visit(grid, to_world, threads, look, [&](const LookUps& l, size_t count, size_t row, size_t first) {
        for (size_t x = 0; x < count; ++x) {
            const Rgb texel = Rgb{l.sums[x][0], l.sums[x][1], l.sums[x][2]} * weight;
            if (!(texel == Rgb{})) texels[texels.index(first + x, row)] = texel;
        }
    });
    return texels;
}

/// Solid angle of a pixel in a row.
double pixel_sr(const Image& image, int row) {
    const double height = image.height;
    return (std::cos(M_PI * row / height) - std::cos(M_PI * (row + 1) / height)) * 2 * M_PI / image.width;
}

/// Pixels in blocks that are at least `side` radians wide and high, where pixels are smaller: they get narrow
/// towards the poles.
class Blocks {
public:
    Blocks(const Image& image, double side)
        : image_(image), first_(size_t(std::clamp(int(M_PI / side), 1, image.height))) {
        for (size_t& first : first_) {
            first = size_;
            const double around =
                2 * M_PI * std::sin(M_PI * (double(count_.size()) + 0.5) / double(first_.size()));
            count_.push_back(size_t(std::clamp(int(around / side), 1, image.width)));
            size_ += count_.back();
        }
    }
    size_t size() const { return size_; }
    size_t of(int row, int column) const {
        const size_t band = size_t(row) * first_.size() / size_t(image_.height);
        return first_[band] + size_t(column) * count_[band] / size_t(image_.width);
    }
    /// Of a place (u, v).
    size_t at(float u, float v) const {
        return of(std::min(int(v * float(image_.height)), image_.height - 1),
                  std::min(int(u * float(image_.width)), image_.width - 1));
    }

private:
    const Image& image_;
    std::vector<size_t> first_, count_;  // by band of rows
    size_t size_ = 0;
};

/// Texels that have the light of each block, whatever the number of look-ups that meet it: what a block sends
/// is dealt evenly to them.
OctahedralTexels deal(const Image& image, Rgb scale, const Affine& to_world, int n, int threads) {
    const Grid grid{n, 8};  // so dense that some meet each block, under any rotation
    const Blocks blocks(image, std::sqrt(4 * M_PI) / n);
    std::vector<uint32_t> met(blocks.size());
    const size_t each = size_t(grid.sub);
    visit(
        grid, to_world, threads,
        [&](const LookUps& l, size_t count) {
            for (size_t k = 0; k < count * each; ++k)
                std::atomic_ref(met[blocks.at(l.u[k], l.v[k])]).fetch_add(1, std::memory_order_relaxed);
        },
        [](auto&&...) {});
    std::vector<Rgb> share(blocks.size());
    with_pixels(image, [&](auto pixel) {
        for (int y = 0; y < image.height; ++y) {
            const double look_ups = pixel_sr(image, y) / grid.look_up_sr();
            for (int x = 0; x < image.width; ++x)
                if (const size_t b = blocks.of(y, x); met[b])
                    share[b] += pixel(size_t(y) * size_t(image.width) + size_t(x)) * float(look_ups / met[b]);
        }
    });
    return means(grid, scale, to_world, threads, [&](LookUps& l, size_t count) {
        for (size_t x = 0, k = 0; x < count; ++x)
            for (const size_t end = k + each; k < end; ++k)
                l.sums[x] += LookUps::lanes(share[blocks.at(l.u[k], l.v[k])]);
    });
}

}  // namespace

double latlong_power(const Image& image, Rgb scale, int first, int last) {
    return with_pixels(image, [&](auto pixel) {
        double power = 0;
        for (int y = first; y < last; ++y) {
            double row = 0;
            for (int x = 0; x < image.width; ++x)
                row += luminance_in_double(pixel(size_t(y) * size_t(image.width) + size_t(x)) * scale);
            power += row * pixel_sr(image, y);
        }
        return power;
    });
}

bool usable_radiance(Rgb c) { return is_finite(c) && c.x >= 0 && c.y >= 0 && c.z >= 0; }

ResampledImage resample_latlong(const Image& image, Rgb scale, const Affine& to_world, int resolution,
                                int threads) {
    check_latlong(image, scale, to_world, resolution);
    // Texels no larger than a pixel at the equator: 4π/N² <= its solid angle
    const double same = std::sqrt(2.0 * image.width * image.height / M_PI);
    const int n =
        resolution ? resolution : int(std::bit_ceil(unsigned(std::clamp<double>(same, 2, kMaxAutomatic))));
    // At least two lookups per pixel edge. They miss light in a few pixels at a pole, which are narrower
    const int sub = std::clamp(int(std::ceil(2 * same / n)), 2, 64);
    const double wanted = latlong_power(image, scale, 0, image.height);
    ResampledImage map;
    map.texels = with_pixels(image, [&](auto pixel) {
        return means({n, sub}, scale, to_world, threads,
                     [&](LookUps& l, size_t count) { l.add_bilinear(image, pixel, count, size_t(sub)); });
    });
    const auto ratio = [&] { return wanted > 0 ? map.texels.power() / wanted : 1; };
    map.power_ratio = ratio();
    if (!(std::abs(map.power_ratio - 1) <= kPowerTolerance)) {
        map.texels = deal(image, scale, to_world, n, threads);
        map.power_ratio = ratio();
    }
    const auto correction = float(1 / map.power_ratio);
    map.texels.each([&](size_t i) {
        Rgb& texel = map.texels[i];
        if (!(texel == Rgb{})) texel = texel * correction;
    });
    return map;
}

}  // namespace viscache

#include "viscache/scene/image.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace viscache {

float srgb_to_linear(float c) { return c <= 0.04045f ? c / 12.92f : std::pow((c + 0.055f) / 1.055f, 2.4f); }

float linear_to_srgb(float c) {
    return c <= 0.0031308f ? c * 12.92f : 1.055f * std::pow(c, 1 / 2.4f) - 0.055f;
}

namespace {

using Table = std::array<float, 256>;

Table table(bool srgb) {
    Table values;
    for (int i = 0; i < 256; ++i) {
        const float plain = float(i) / 255.f;
        values[size_t(i)] = srgb ? srgb_to_linear(plain) : plain;
    }
    return values;
}

const Table kLinearBytes = table(false), kSrgbBytes = table(true);

/// The coordinate without whole periods, so that the index of its pixel is small.
float folded(float x, Wrap wrap) {
    switch (wrap) {
        case Wrap::kRepeat: return x - std::floor(x);
        case Wrap::kMirror: return x - 2 * std::floor(x / 2);
        case Wrap::kClamp: return std::clamp(x, 0.f, 1.f);
    }
    return x;
}

/// The pixel that stands for index i of n, -2n <= i <= 2n.
int wrapped(int i, int n, Wrap wrap) {
    switch (wrap) {
        case Wrap::kRepeat: return (i + n) % n;
        case Wrap::kMirror: {
            const int place = (i + 2 * n) % (2 * n);
            return std::min(place, 2 * n - 1 - place);
        }
        case Wrap::kClamp: return std::clamp(i, 0, n - 1);
    }
    return i;
}

/// `texel(first, c)` is channel c of the pixel whose values start at `first`.
template <class Texel>
Rgba look_up(const Image& image, Vec2 uv, Texel texel) {
    const float u = folded(uv.x, image.wrap_u), v = folded(uv.y, image.wrap_v);
    float x = u * image.width - 0.5f, y = (1 - v) * image.height - 0.5f;
    if (image.nearest) {
        x = std::floor(u * image.width);
        y = image.height - 1 - std::floor(v * image.height);
    }
    const int x0 = int(std::floor(x)), y0 = int(std::floor(y));
    const float fx = x - x0, fy = y - y0;
    float sum[4] = {};
    for (int dy = 0; dy < 2; ++dy)
        for (int dx = 0; dx < 2; ++dx) {
            const int xi = wrapped(x0 + dx, image.width, image.wrap_u),
                      yi = wrapped(y0 + dy, image.height, image.wrap_v);
            const float weight = (dx ? fx : 1 - fx) * (dy ? fy : 1 - fy);
            const size_t first = (size_t(yi) * image.width + xi) * image.channels;
            for (int c = 0; c < image.channels && c < 4; ++c) sum[c] += weight * texel(first, c);
        }
    switch (image.channels) {
        case 1: return {{sum[0], sum[0], sum[0]}, 1};
        case 2: return {{sum[0], sum[0], sum[0]}, sum[1]};
        case 3: return {{sum[0], sum[1], sum[2]}, 1};
        default: return {{sum[0], sum[1], sum[2]}, sum[3]};
    }
}

}  // namespace

const float* byte_values(bool srgb) { return (srgb ? kSrgbBytes : kLinearBytes).data(); }

Rgba sample_image(const Image& image, Vec2 uv) {
    if (image.width <= 0 || !std::isfinite(uv.x) || !std::isfinite(uv.y)) return {{0.5f, 0.5f, 0.5f}, 1};
    if (image.bytes.empty()) {
        const float* pixels = image.pixels.data();
        return look_up(image, uv, [=](size_t first, int c) { return pixels[first + size_t(c)]; });
    }
    const float* values[4];
    for (int c = 0; c < 4; ++c) values[c] = image.values_of(c);
    const uint8_t* bytes = image.bytes.data();
    return look_up(image, uv, [&](size_t first, int c) { return values[c][bytes[first + size_t(c)]]; });
}

}  // namespace viscache

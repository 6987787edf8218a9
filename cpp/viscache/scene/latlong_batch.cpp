#include "viscache/scene/latlong_batch.h"

#include <cmath>
#include <cstring>

#include "viscache/math/isa_variants.h"
#include "viscache/sampling/warp.h"

namespace viscache {
namespace {

/// Arc tangent of a in [0, 1] over 2π, within 3e-8: a polynomial in a², fitted at Chebyshev's nodes.
inline __attribute__((always_inline)) float turns_of(float a) {
    constexpr float k[] = {0.159154922f,  -0.0530494601f,  0.0317820236f,  -0.0223080888f,
                           0.0157660432f, -0.00944856741f, 0.00384616852f, -0.000743058336f};
    const float s = a * a;
    return a *
           (k[0] + s * (k[1] + s * (k[2] + s * (k[3] + s * (k[4] + s * (k[5] + s * (k[6] + s * k[7])))))));
}

/// Angle of (x, y) from the x axis, y ≥ 0, over 2π: in [0, ½]. 0 for (0, 0).
inline __attribute__((always_inline)) float half_turns(float y, float x) {
    const float ax = std::fabs(x), high = ax > y ? ax : y, low = ax > y ? y : ax;
    const float eighth = turns_of(low / (high > 0 ? high : 1.f));
    const float quarter = ax > y ? eighth : 0.25f - eighth;
    return x < 0 ? 0.5f - quarter : quarter;
}

inline __attribute__((always_inline)) void fill(const LatLongTurn& turn, float y, float first, float step,
                                                size_t n, float* u, float* v) {
    const auto& m = turn.rows;
    const float b = 2 * y - 1, ab = std::fabs(b);
    for (size_t i = 0; i < n; ++i) {
        // The direction, as equal_area_to_direction
        const float a = 2 * ((first + float(int(i))) * step) - 1, aa = std::fabs(a);
        const float distance = 1 - (aa + ab), r = 1 - std::fabs(distance);
        const float angle = (kPi / 4) * ((ab - aa) / (r > 0 ? r : 1));
        const float c = cos_eighth(angle), s = sin_eighth(angle);
        const float side = r * std::sqrt(2 - r * r) * 0.70710678f;
        const float dx = std::copysign((c - s) * side, a), dy = std::copysign((c + s) * side, b);
        const float dz = std::copysign(1 - r * r, distance);
        // In the image's frame
        const float x = m[0][0] * dx + m[0][1] * dy + m[0][2] * dz;
        const float h = m[1][0] * dx + m[1][1] * dy + m[1][2] * dz;
        const float z = m[2][0] * dx + m[2][1] * dy + m[2][2] * dz;
        // u = atan2(x, -z)/2π mod 1; v from the angle to the pole, accurate near both
        const float around = half_turns(std::fabs(x), -z);
        u[i] = x < 0 ? 1 - around : around;
        v[i] = 2 * half_turns(std::sqrt(x * x + z * z), h);
    }
}

inline __attribute__((always_inline)) void place(const float* u, const float* v, size_t n, int width,
                                                 int height, BilinearPlaces& out) {
    int greatest = 0;
    for (size_t i = 0; i < n; ++i) {
        const float x = u[i] * float(width) - 0.5f, y = v[i] * float(height) - 0.5f;
        const int x0 = int(x + 1) - 1, y0 = int(y + 1) - 1;  // x and y are at least -1/2
        const int left = x0 < 0 ? width - 1 : x0, right = x0 + 1 == width ? 0 : x0 + 1;
        const int up = y0 < 0 ? 0 : y0, down = y0 + 1 < height ? y0 + 1 : height - 1;
        out.up_left[i] = up * width + left;
        out.up_right[i] = up * width + right;
        out.down_left[i] = down * width + left;
        out.down_right[i] = down * width + right;
        out.right[i] = x - float(x0);
        out.down[i] = y - float(y0);
        greatest = out.down_left[i] > greatest ? out.down_left[i] : greatest;
        greatest = out.down_right[i] > greatest ? out.down_right[i] : greatest;
    }
    out.greatest = greatest;
}

inline __attribute__((always_inline)) void sum(const float* rgb, const BilinearPlaces& places, size_t each,
                                               ColorLanes* sums, size_t n) {
    const auto pixel = [rgb](int32_t i) __attribute__((always_inline)) {
        ColorLanes four;
        std::memcpy(&four, rgb + 3 * ptrdiff_t(i), sizeof four);
        return four;
    };
    for (size_t x = 0, k = 0; x < n; ++x) {
        ColorLanes total = sums[x];
        for (size_t end = k + each; k < end; ++k) total += bilinear(places, k, pixel);
        sums[x] = total;
    }
}

}  // namespace

LatLongTurn::LatLongTurn(const Affine& to_world) {
    const auto& m = to_world.m;
    const double scale = std::sqrt(m[0][0] * m[0][0] + m[1][0] * m[1][0] + m[2][0] * m[2][0]);
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) rows[i][j] = float(m[j][i] / scale);
}

void latlong_batch(const LatLongTurn& turn, float y, float first, float step, size_t n, float* u, float* v,
                   Isa isa) {
    variant_of<fill>(isa)(turn, y, first, step, n, u, v);
}

void bilinear_places(std::span<const float> u, std::span<const float> v, int width, int height,
                     BilinearPlaces& out, Isa isa) {
    variant_of<place>(isa)(u.data(), v.data(), u.size(), width, height, out);
}

void sum_bilinear(const float* rgb, const BilinearPlaces& places, size_t each, std::span<ColorLanes> sums,
                  Isa isa) {
    variant_of<sum>(isa)(rgb, places, each, sums.data(), sums.size());
}

}  // namespace viscache

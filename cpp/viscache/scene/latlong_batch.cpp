#include "viscache/scene/latlong_batch.h"

#include <cmath>

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

#if VISCACHE_X86
VISCACHE_TARGET_AVX512 void fill_avx512(const LatLongTurn& turn, float y, float first, float step, size_t n,
                                        float* u, float* v) {
    fill(turn, y, first, step, n, u, v);
}
VISCACHE_TARGET_AVX2 void fill_avx2(const LatLongTurn& turn, float y, float first, float step, size_t n,
                                    float* u, float* v) {
    fill(turn, y, first, step, n, u, v);
}
#endif

}  // namespace

LatLongTurn::LatLongTurn(const Affine& to_world) {
    const auto& m = to_world.m;
    const double scale = std::sqrt(m[0][0] * m[0][0] + m[1][0] * m[1][0] + m[2][0] * m[2][0]);
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) rows[i][j] = float(m[j][i] / scale);
}

void latlong_batch(const LatLongTurn& turn, float y, float first, float step, size_t n, float* u, float* v,
                   [[maybe_unused]] Isa isa) {
#if VISCACHE_X86
    if (isa == Isa::kAvx512) return fill_avx512(turn, y, first, step, n, u, v);
    if (isa == Isa::kAvx2) return fill_avx2(turn, y, first, step, n, u, v);
#endif
    fill(turn, y, first, step, n, u, v);
}

}  // namespace viscache

#include "viscache/vismap/product_kernels.h"

#include <cmath>

#include "viscache/math/isa_variants.h"

namespace viscache {
namespace {

#define VISCACHE_INLINE inline __attribute__((always_inline))

// A cone of sine s around ω reaches above the plane of n if n·ω > −s. Both planes must be reached: B is 0
// below either.
VISCACHE_INLINE void above_body(const LobeConstants& k, const float* x, const float* y, const float* z,
                                const float* sine, uint8_t* above, size_t n) {
    for (size_t i = 0; i < n; ++i) {
        const float c = (k.ns.x * x[i] + k.ns.y * y[i]) + k.ns.z * z[i];
        const float g = (k.ng.x * x[i] + k.ng.y * y[i]) + k.ng.z * z[i];
        // Without branches, so that the loop is vectorised.
        above[i] = uint8_t(int(c > -sine[i]) & int(g > -sine[i]));
    }
}

VISCACHE_INLINE float mean_of_four(const float* v) { return ((v[0] + v[1]) + (v[2] + v[3])) * 0.25f; }
VISCACHE_INLINE float least_of(float a, float b) { return a < b ? a : b; }
VISCACHE_INLINE float most_of(float a, float b) { return a > b ? a : b; }

// Sixteen samples along the Morton curve are four leaves of four.
VISCACHE_INLINE float gather_body(const RgbBlock& s, float* r, float* g, float* b, float* lum,
                                  float* spread) {
    float samples[16], greatest = 0;
    for (int i = 0; i < 16; ++i) samples[i] = (0.2126f * s.r[i] + 0.7152f * s.g[i]) + 0.0722f * s.b[i];
    for (int i = 0; i < 4; ++i) {
        const float* v = &samples[4 * i];
        r[i] = mean_of_four(&s.r[4 * i]);
        g[i] = mean_of_four(&s.g[4 * i]);
        b[i] = mean_of_four(&s.b[4 * i]);
        lum[i] = (0.2126f * r[i] + 0.7152f * g[i]) + 0.0722f * b[i];
        // The error of a constant: the range of its samples.
        spread[i] = most_of(most_of(v[0], v[1]), most_of(v[2], v[3])) -
                    least_of(least_of(v[0], v[1]), least_of(v[2], v[3]));
        greatest = most_of(greatest, lum[i]);
    }
    return greatest;
}

// The weights of luminance add up to one, so the same amount for all channels raises it by this amount.
VISCACHE_INLINE void raise_body(const uint8_t* touched, float floor, float* r, float* g, float* b, float* lum,
                                size_t n) {
    for (size_t i = 0; i < n; ++i) {
        const bool low = touched[i] && lum[i] < floor;
        const float add = low ? floor - lum[i] : 0.f;
        r[i] += add;
        g[i] += add;
        b[i] += add;
        lum[i] = low ? floor : lum[i];
    }
}

// Eight partial sums, added in pairs at the end: one order of additions for every variant.
VISCACHE_INLINE double weigh_body(const float* b, const double* light, size_t n) {
    double lane[8]{};
    for (size_t i = 0; i < n; i += 8)
        for (size_t k = 0; k < 8; ++k) lane[k] += double(b[i + k]) * light[i + k];
    return ((lane[0] + lane[1]) + (lane[2] + lane[3])) + ((lane[4] + lane[5]) + (lane[6] + lane[7]));
}

VISCACHE_INLINE void flag_body(const float* spread, const double* light, double threshold, uint8_t* flags,
                               size_t n) {
    for (size_t i = 0; i < n; ++i) flags[i] = uint8_t(double(spread[i]) * light[i] > threshold);
}

// With a constant span, the inner loop becomes a vector operation.
template <size_t kSpan>
VISCACHE_INLINE void scale_by(const float* b, const double* light, double* out, size_t n) {
    for (size_t i = 0; i < n; ++i)
        for (size_t k = 0; k < kSpan; ++k) out[i * kSpan + k] = double(b[i]) * light[i * kSpan + k];
}
VISCACHE_INLINE void scale_body(const float* b, const double* light, double* out, size_t n, size_t span) {
    if (span == 1) return scale_by<1>(b, light, out, n);
    if (span == 4) return scale_by<4>(b, light, out, n);
    scale_by<16>(b, light, out, n);
}

VISCACHE_INLINE void sum_fours_body(const double* c, double* parents, size_t n) {
    // Along the Morton curve, the four children of a node are neighbours.
    for (size_t i = 0; i < n; ++i) parents[i] = (c[4 * i] + c[4 * i + 1]) + (c[4 * i + 2] + c[4 * i + 3]);
}

#undef VISCACHE_INLINE

constexpr ProductKernels product_kernels_of(Isa isa) {
    return {variant_of<diffuse16>(isa),   variant_of<glossy16>(isa),   variant_of<above_body>(isa),
            variant_of<gather_body>(isa), variant_of<raise_body>(isa), variant_of<weigh_body>(isa),
            variant_of<flag_body>(isa),   variant_of<scale_body>(isa), variant_of<sum_fours_body>(isa)};
}

}  // namespace

const ProductKernels& product_kernels(Isa isa) { return table_of<product_kernels_of>(isa); }

}  // namespace viscache

#pragma once
// Reflection for sixteen directions at a time: `eval_bsdf`·cos and `pdf_bsdf` up to float rounding, without
// branches. Kernels of every instruction set inline these bodies.
#include <cstddef>

#include "viscache/math/isa.h"
#include "viscache/scene/bsdf.h"

namespace viscache {

/// Sixteen colours.
struct RgbBlock {
    alignas(64) float r[16];
    alignas(64) float g[16];
    alignas(64) float b[16];
};

/// Reflection at one point: all terms that do not depend on the incoming direction.
struct LobeConstants {
    Vec3 ns, ng, wo;
    Rgb diffuse;  ///< diffuse part of f; under a lobe, without its factor 1 − (1 − cos_i)⁵, T(cos_i) or 1 −
                  ///< F'
    Rgb f0;       ///< F0 of the lobe; under a coat and of a metal, the factor of its reflection
    float cos_o = 0, alpha2 = 1;
    float outgoing = 0;                    ///< G1(cos_o)/(4 cos_o)
    float share = 0;                       ///< probability of sampling the lobe
    float eta = 1;                         ///< of the coat
    const float* transmittance = nullptr;  ///< steps of the coat's T; nullptr: no coat
    const Conductor* metal = nullptr;      ///< nullptr: none
    FresnelMix mix{};
    bool glossy = false;
    bool beckmann = false;
    bool black = true;  ///< the surface reflects no light
};

LobeConstants lobe_constants(const ShadingPoint& point);

/// A lobe is sharp if its peak is so many times the reflection of a diffuse surface of the same albedo.
/// Chosen for samples beside shared directions of the sky (docs/performance/skies.md).
constexpr float kSharp = 3;
/// The same, but `share` is 1 where the lobe is sharp, so that densities are those of its samples alone, and
/// 0 elsewhere.
LobeConstants sharp_lobe(const ShadingPoint& point);

/// f·cos of a diffuse surface.
inline __attribute__((always_inline)) void diffuse16(const LobeConstants& k, const float* x, const float* y,
                                                     const float* z, RgbBlock& out) {
    for (int i = 0; i < 16; ++i) {
        const float c = (k.ns.x * x[i] + k.ns.y * y[i]) + k.ns.z * z[i];
        const float g = (k.ng.x * x[i] + k.ng.y * y[i]) + k.ng.z * z[i];
        const float cos = c > 0 && g > 0 ? c : 0.f;
        out.r[i] = k.diffuse.x * cos;
        out.g[i] = k.diffuse.y * cos;
        out.b[i] = k.diffuse.z * cos;
    }
}

/// e^x for x <= 0, to 1e-5, by the same operations in all lanes; 0 below 2^-126.
inline __attribute__((always_inline)) float exp_of_negative(float x) {
    const float power = x * 1.44269504f, held = power > -126.f ? power : -126.f;
    const int whole = int(held);  // rounded up
    const float f = (held - float(whole)) * 0.69314718f;
    float sum = 1.98412698e-4f * f + 1.38888889e-3f;  // the series of e^f, -0.7 < f <= 0
    sum = sum * f + 8.33333333e-3f;
    sum = sum * f + 4.16666667e-2f;
    sum = sum * f + 1.66666667e-1f;
    sum = sum * f + 0.5f;
    sum = sum * f + 1.f;
    sum = sum * f + 1.f;
    return float(int(power > -126.f)) * sum * __builtin_bit_cast(float, (whole + 127) << 23);
}

/// The half vector of two directions on one side of a surface, with D of the microfacets. The sine comes
/// from the tangential part of the half vector, which keeps it accurate for sharp lobes.
struct HalfVector {
    float d;
    float sum2;   ///< |w + o|² = (2 w·h)²
    float along;  ///< cos_i + cos_o
};
template <bool kBeckmann>
inline __attribute__((always_inline)) HalfVector half_vector(const LobeConstants& k, float x, float y,
                                                             float z, float cos_i) {
    const float hx = k.wo.x + x, hy = k.wo.y + y, hz = k.wo.z + z, along = cos_i + k.cos_o;
    const float l2 = (hx * hx + hy * hy) + hz * hz, sum2 = l2 > 1e-12f ? l2 : 1e-12f;
    const float px = hx - k.ns.x * along, py = hy - k.ns.y * along, pz = hz - k.ns.z * along;
    const float across2 = (px * px + py * py) + pz * pz, along2 = along * along;
    if constexpr (kBeckmann) {
        const float raw = along2 / sum2, cos2 = raw > 1e-12f ? raw : 1e-12f;
        const float power = -across2 / (k.alpha2 * cos2 * sum2);
        return {exp_of_negative(power) / (kPi * k.alpha2 * (cos2 * cos2)), sum2, along};
    }
    const float t = (across2 + k.alpha2 * along2) / sum2;
    return {k.alpha2 / (kPi * t * t), sum2, along};
}

/// The lobe without its Fresnel term, for one direction.
struct LobeValue {
    float on;        ///< 1 if the direction is above both planes, or else 0
    float cos;       ///< its cosine; 1 below, which avoids division by zero
    float half;      ///< cosine to the half vector
    float shadowed;  ///< D·G/(4 cos_o)
};
template <bool kBeckmann>
inline __attribute__((always_inline)) LobeValue lobe_value(const LobeConstants& k, float x, float y,
                                                           float z) {
    const float c = (k.ns.x * x + k.ns.y * y) + k.ns.z * z;
    const float g = (k.ng.x * x + k.ng.y * y) + k.ng.z * z;
    // Products in place of branches, which would keep compilers from using vectors
    const float on = float(int(c > 0) & int(g > 0)), cos = on * c + (1 - on);
    const HalfVector h = half_vector<kBeckmann>(k, x, y, z, cos);
    const float sin2 = 1 - cos * cos > 0 ? 1 - cos * cos : 0.f;
    float seen;
    if constexpr (kBeckmann) {
        const float a2 = cos * cos / (k.alpha2 * (sin2 > 1e-12f ? sin2 : 1e-12f)), a = __builtin_sqrtf(a2);
        const float b = a < 1.6f ? a : 1.6f;  // there, the fit ends with 1
        seen = (3.535f * b + 2.181f * b * b) / (1 + 2.276f * b + 2.577f * b * b);
    } else {
        seen = 2 * cos / (cos + __builtin_sqrtf(cos * cos + k.alpha2 * sin2));
    }
    return {on, cos, 0.5f * __builtin_sqrtf(h.sum2), h.d * k.outgoing * seen};
}

/// f·cos of a metal.
template <bool kBeckmann>
inline __attribute__((always_inline)) void metal16(const LobeConstants& k, const float* x, const float* y,
                                                   const float* z, RgbBlock& out) {
    for (int i = 0; i < 16; ++i) {
        const LobeValue v = lobe_value<kBeckmann>(k, x[i], y[i], z[i]);
        const float half = v.half < 1 ? v.half : 1.f, lobe = v.on * v.shadowed;
        out.r[i] = k.f0.x * lobe * fresnel_channel(half, k.metal->eta.x, k.metal->k.x);
        out.g[i] = k.f0.y * lobe * fresnel_channel(half, k.metal->eta.y, k.metal->k.y);
        out.b[i] = k.f0.z * lobe * fresnel_channel(half, k.metal->eta.z, k.metal->k.z);
    }
}

/// f·cos of a glossy surface under a coat.
template <bool kBeckmann>
inline __attribute__((always_inline)) void coated16(const LobeConstants& k, const float* x, const float* y,
                                                    const float* z, RgbBlock& out) {
    for (int i = 0; i < 16; ++i) {
        const LobeValue v = lobe_value<kBeckmann>(k, x[i], y[i], z[i]);
        const float lobe = fresnel_outside(v.half, k.eta) * v.shadowed;
        const float entry = transmitted(k.transmittance, v.cos) * v.cos;
        out.r[i] = v.on * (k.diffuse.x * entry + k.f0.x * lobe);
        out.g[i] = v.on * (k.diffuse.y * entry + k.f0.y * lobe);
        out.b[i] = v.on * (k.diffuse.z * entry + k.f0.z * lobe);
    }
}

/// f·cos of a Fresnel mix.
inline __attribute__((always_inline)) void mixed16(const LobeConstants& k, const float* x, const float* y,
                                                   const float* z, RgbBlock& out) {
    const float left = 1 - k.mix.taken, falls = k.mix.taken90 - k.mix.taken;
    for (int i = 0; i < 16; ++i) {
        const LobeValue v = lobe_value<false>(k, x[i], y[i], z[i]);
        const float m = 1 - v.half, mm = m > 0 ? m : 0.f, m5 = mm * mm * mm * mm * mm;
        const float entry = (left - falls * m5) * v.cos, lobe = v.shadowed;
        out.r[i] = v.on * (k.diffuse.x * entry + (k.f0.x + (k.mix.f90 - k.f0.x) * m5) * lobe);
        out.g[i] = v.on * (k.diffuse.y * entry + (k.f0.y + (k.mix.f90 - k.f0.y) * m5) * lobe);
        out.b[i] = v.on * (k.diffuse.z * entry + (k.f0.z + (k.mix.f90 - k.f0.z) * m5) * lobe);
    }
}

template <bool kBeckmann>
inline __attribute__((always_inline)) void glossy16_of(const LobeConstants& k, const float* x, const float* y,
                                                       const float* z, RgbBlock& out) {
    if (k.transmittance) return coated16<kBeckmann>(k, x, y, z, out);
    if (k.metal) return metal16<kBeckmann>(k, x, y, z, out);
    if (k.mix.on) return mixed16(k, x, y, z, out);
    for (int i = 0; i < 16; ++i) {
        const LobeValue v = lobe_value<kBeckmann>(k, x[i], y[i], z[i]);
        const float cos = v.cos, lobe = v.shadowed;
        const float m = 1 - v.half, mm = m > 0 ? m : 0.f, m5 = mm * mm * mm * mm * mm;
        const float e = 1 - cos, entry = (1 - e * e * e * e * e) * cos;
        out.r[i] = v.on * (k.diffuse.x * entry + (k.f0.x + (1 - k.f0.x) * m5) * lobe);
        out.g[i] = v.on * (k.diffuse.y * entry + (k.f0.y + (1 - k.f0.y) * m5) * lobe);
        out.b[i] = v.on * (k.diffuse.z * entry + (k.f0.z + (1 - k.f0.z) * m5) * lobe);
    }
}

/// f·cos of a glossy surface.
inline __attribute__((always_inline)) void glossy16(const LobeConstants& k, const float* x, const float* y,
                                                    const float* z, RgbBlock& out) {
    if (k.beckmann)
        glossy16_of<true>(k, x, y, z, out);
    else
        glossy16_of<false>(k, x, y, z, out);
}

template <bool kBeckmann>
inline __attribute__((always_inline)) void density16_of(const LobeConstants& k, const float* x,
                                                        const float* y, const float* z, float* pdf) {
    for (int i = 0; i < 16; ++i) {
        const float c = (k.ns.x * x[i] + k.ns.y * y[i]) + k.ns.z * z[i];
        const float g = (k.ng.x * x[i] + k.ng.y * y[i]) + k.ng.z * z[i];
        const float on = float(int(c > 0) & int(g > 0)), cos = on * c + (1 - on);
        const HalfVector h = half_vector<kBeckmann>(k, x[i], y[i], z[i], cos);
        // All normals are sampled by Beckmann's D·cos, visible ones by GGX's
        const float sampled = kBeckmann ? h.along / (2 * h.sum2) : k.outgoing;
        const float both = (1 - k.share) * cos * (1 / kPi) + k.share * h.d * sampled;
        pdf[i] = on * both;
    }
}

/// Densities of `sample_bsdf`.
inline __attribute__((always_inline)) void density16(const LobeConstants& k, const float* x, const float* y,
                                                     const float* z, float* pdf) {
    if (k.beckmann)
        density16_of<true>(k, x, y, z, pdf);
    else
        density16_of<false>(k, x, y, z, pdf);
}

/// f·cos and densities of n directions; n is a multiple of 16. All variants give the same bits.
struct ReflectedDirections {
    const float *x, *y, *z;
    float *r, *g, *b, *pdf;
};
void reflect_directions(const LobeConstants& lobe, const ReflectedDirections& directions, size_t n,
                        Isa isa = active_isa());

}  // namespace viscache

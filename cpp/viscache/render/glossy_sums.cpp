#include "viscache/render/glossy_sums.h"

#include <algorithm>
#include <optional>

#include "viscache/math/isa_variants.h"
#include "viscache/scene/lobes.h"

namespace viscache {
namespace {

// Bodies are compiled once per instruction set, so all that they call must be inlined into them: a
// shared copy would have the instructions of one set only
#define VISCACHE_INLINED __attribute__((always_inline))
#define VISCACHE_INLINE inline VISCACHE_INLINED

/// Unit directions to the sixteen columns from k on, and the factor of f·cos. Diffuse kernels do without a
/// unit direction, but a lobe is a function of its angles.
template <Semantic kSemantic>
VISCACHE_INLINE void aim(const SharedLights& s, Vec3 p, size_t k, float* x, float* y, float* z,
                         float* scale) {
    const FarEnds& e = s.ends;
    for (size_t i = 0; i < 16; ++i) {
        if constexpr (kSemantic == Semantic::kDirection) {
            x[i] = e.x[k + i];
            y[i] = e.y[k + i];
            z[i] = e.z[k + i];
            scale[i] = 1;
        } else {
            const float dx = e.x[k + i] - p.x, dy = e.y[k + i] - p.y, dz = e.z[k + i] - p.z;
            // A division and a correctly rounded root, as in every instruction set; no approximate
            // reciprocal
            const float d2 = dx * dx + dy * dy + dz * dz, inverse = 1 / __builtin_sqrtf(d2);
            x[i] = dx * inverse;
            y[i] = dy * inverse;
            z[i] = dz * inverse;
            if constexpr (kSemantic == Semantic::kPoint) {
                // The cosine at the eye point is a part of what the lobe returns
                scale[i] = 1 / d2;
            } else {
                const float far_cos = -(e.nx[k + i] * x[i] + e.ny[k + i] * y[i] + e.nz[k + i] * z[i]);
                scale[i] = (far_cos > 0 ? far_cos : 0.f) / (d2 + s.bound2);
            }
        }
    }
}

/// Visits blocks of sixteen columns with set bits: first column, bits, f·cos and its factor per column.
template <Semantic kSemantic, class Visit>
VISCACHE_INLINE void for_each_block(const SharedLights& s, const EyeShade& eye, const LobeConstants& lobe,
                                    const Word* row, Visit visit) {
    alignas(64) float x[16], y[16], z[16], scale[16], pdf[16];
    RgbBlock f;
    // Samples of sharp lobes bring the rest (balance heuristic)
    const bool balanced = s.has_lobes() && lobe.share > 0;
    const float* const cone = cone_row(s, eye.position);
    for (size_t w = 0; w < row_words_for(s.ends.count); ++w)
        // Ends as soon as no set bit is left in the word
        for (size_t q = 0; q < kWordBits && row[w] >> q; q += 16) {
            const uint32_t mask = row[w] >> q & 0xffff;
            if (!mask) continue;
            const size_t k = w * kWordBits + q;
            aim<kSemantic>(s, eye.position, k, x, y, z, scale);
            if (cone)
                for (size_t i = 0; i < 16; ++i) scale[i] *= cone[k + i];
            // 1/(1 + ratio·pdf) is the weight of light sampling; samples of the lobe carry the
            // rest, so that both together count once
            if (balanced) {
                density16(lobe, x, y, z, pdf);
                for (size_t i = 0; i < 16; ++i) scale[i] *= 1 / (1 + s.lobe_ratio[k + i] * pdf[i]);
            }
            glossy16(lobe, x, y, z, f);
            visit(k, mask, f, scale);
        }
}

template <Semantic kSemantic>
VISCACHE_INLINE Rgb sum_as(const SharedLights& s, const EyeShade& eye, const LobeConstants& lobe,
                           const Word* row) {
    alignas(64) float r[16] = {}, g[16] = {}, b[16] = {};
    // The same sixteen running sums as `sum_row`, so that the order is one for both kinds of
    // surfaces
    const auto add = [&](size_t k, uint32_t mask, const RgbBlock& f, const float* scale) VISCACHE_INLINED {
        for (uint32_t i = 0; i < 16; ++i) {
            // Columns whose bit is not set may hold any value
            const bool seen = mask >> i & 1;
            const float fr = seen ? f.r[i] * scale[i] : 0.f, fg = seen ? f.g[i] * scale[i] : 0.f,
                        fb = seen ? f.b[i] * scale[i] : 0.f;
            r[i] += fr * s.r[k + i];
            g[i] += fg * s.g[k + i];
            b[i] += fb * s.b[k + i];
        }
    };
    for_each_block<kSemantic>(s, eye, lobe, row, add);
    // A fixed tree: the same bits with every instruction set
    for (size_t step = 8; step; step /= 2)
        for (size_t i = 0; i < step; ++i) {
            r[i] += r[i + step];
            g[i] += g[i + step];
            b[i] += b[i + step];
        }
    return {r[0], g[0], b[0]};
}

VISCACHE_INLINE Rgb sum_body(const SharedLights& s, const EyeShade& eye, const LobeConstants& lobe,
                             const Word* row) {
    switch (s.ends.semantic) {
        case Semantic::kPoint: return sum_as<Semantic::kPoint>(s, eye, lobe, row);
        case Semantic::kDirection:
        case Semantic::kSolidAngle: return sum_as<Semantic::kDirection>(s, eye, lobe, row);
        case Semantic::kSurface: return sum_as<Semantic::kSurface>(s, eye, lobe, row);
    }
    return {};
}

template <Semantic kSemantic>
VISCACHE_INLINE float contributions_as(const SharedLights& s, const EyeShade& eye, const LobeConstants& lobe,
                                       const Word* row, float* c) {
    // Counts as floats stay in vector registers; rows are far shorter than 2²⁴
    alignas(64) float sum[16] = {}, positive[16] = {};
    const auto write = [&](size_t k, uint32_t mask, const RgbBlock& f, const float* scale) VISCACHE_INLINED {
        alignas(64) float kept[16];
        const float *red = &s.r[k], *green = &s.g[k], *blue = &s.b[k];
        for (uint32_t i = 0; i < 16; ++i) {
            const float value = f.r[i] * red[i] + f.g[i] * green[i] + f.b[i] * blue[i];
            kept[i] = mask >> i & 1 ? value * scale[i] : 0.f;
        }
        for (uint32_t i = 0; i < 16; ++i) sum[i] += kept[i];
        for (uint32_t i = 0; i < 16; ++i) positive[i] += kept[i] > 0 ? 1.f : 0.f;
        // Blocks without a set bit keep the zeros of the caller
        std::copy_n(kept, 16, c + k);
    };
    for_each_block<kSemantic>(s, eye, lobe, row, write);
    for (size_t step = 8; step; step /= 2)
        for (size_t i = 0; i < step; ++i) {
            sum[i] += sum[i + step];
            positive[i] += positive[i + step];
        }
    return sum[0] / (positive[0] > 0 ? positive[0] : 1.f);
}

VISCACHE_INLINE float contributions_body(const SharedLights& s, const EyeShade& eye,
                                         const LobeConstants& lobe, const Word* row, float* c) {
    switch (s.ends.semantic) {
        case Semantic::kPoint: return contributions_as<Semantic::kPoint>(s, eye, lobe, row, c);
        case Semantic::kDirection:
        case Semantic::kSolidAngle: return contributions_as<Semantic::kDirection>(s, eye, lobe, row, c);
        case Semantic::kSurface: return contributions_as<Semantic::kSurface>(s, eye, lobe, row, c);
    }
    return 0;
}

#undef VISCACHE_INLINE
#undef VISCACHE_INLINED

/// The lobe; nothing if it reflects no light.
std::optional<LobeConstants> lobe_of(const SharedLights& s, const ShadingPoint& brdf) {
    LobeConstants lobe = sharp_lobe(brdf);
    if (lobe.black) return {};
    // A mirror reflects no light without an extent
    if (s.punctual && brdf.mirror) lobe.f0 = {};
    return lobe;
}

}  // namespace

Rgb sum_row_glossy(const SharedLights& s, const EyeShade& eye, const ShadingPoint& brdf, const Word* row,
                   Isa isa) {
    const auto lobe = lobe_of(s, brdf);
    return lobe ? variant_of<sum_body>(isa)(s, eye, *lobe, row) : Rgb{};
}

float contribution_row_glossy(const SharedLights& s, const EyeShade& eye, const ShadingPoint& brdf,
                              const Word* row, std::vector<float>& contributions, Isa isa) {
    contributions.assign(s.ends.x.size(), 0.f);
    const auto lobe = lobe_of(s, brdf);
    return lobe ? variant_of<contributions_body>(isa)(s, eye, *lobe, row, contributions.data()) : 0;
}

}  // namespace viscache

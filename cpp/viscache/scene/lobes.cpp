#include "viscache/scene/lobes.h"

#include <cstring>

#include "viscache/math/isa_variants.h"

namespace viscache {

LobeConstants lobe_constants(const ShadingPoint& p) {
    LobeConstants k;
    k.glossy = p.kind == MaterialKind::kGlossy;
    const bool reflects = k.glossy || p.kind == MaterialKind::kDiffuse;
    const float cos_o = dot(p.ns, p.wo);
    k.black = !reflects || !(cos_o > 0 && dot(p.ng, p.wo) > 0) || is_black(p);
    k.ns = p.ns;
    k.ng = p.ng;
    k.wo = p.wo;
    // Under a lobe, `diffuse_albedo` is a mean over cosines of a term proportional to 1 − (1 − cos)⁵, whose
    // mean is 20/21, or to the transmittance of the coat
    k.diffuse = diffuse_albedo(p) * ((p.coat ? 1 / p.coat->mean : k.glossy ? 21.f / 20 : 1.f) / kPi);
    k.mix = p.mix;
    if (p.mix.on && !k.black) k.diffuse = p.base / kPi;
    if (p.coat) {
        k.eta = p.coat->eta;
        k.transmittance = p.coat->transmittance.data();
    }
    k.metal = p.metal;
    k.f0 = p.specular;
    k.cos_o = cos_o;
    k.beckmann = p.beckmann;
    k.alpha2 = p.roughness * p.roughness;
    k.outgoing = k.black ? 0.f : lobe_g1(p, cos_o) / (4 * cos_o);
    k.share = k.black ? 0.f : glossy_share(p);
    return k;
}

LobeConstants sharp_lobe(const ShadingPoint& point) {
    LobeConstants k = lobe_constants(point);
    // Straight above, the lobe is share/(4π α²) of the albedo, and a diffuse surface 1/π
    k.share = k.share > 4 * kSharp * k.alpha2 ? 1 : 0;
    return k;
}

namespace {

inline __attribute__((always_inline)) void reflect_body(const LobeConstants& k, const ReflectedDirections& d,
                                                        size_t n) {
    RgbBlock block;
    for (size_t i = 0; i < n; i += 16) {
        if (k.glossy) {
            glossy16(k, d.x + i, d.y + i, d.z + i, block);
            density16(k, d.x + i, d.y + i, d.z + i, d.pdf + i);
        } else {
            diffuse16(k, d.x + i, d.y + i, d.z + i, block);
            for (size_t j = 0; j < 16; ++j) {
                const float c = (k.ns.x * d.x[i + j] + k.ns.y * d.y[i + j]) + k.ns.z * d.z[i + j];
                const float g = (k.ng.x * d.x[i + j] + k.ng.y * d.y[i + j]) + k.ng.z * d.z[i + j];
                d.pdf[i + j] = c > 0 && g > 0 ? c * (1 / kPi) : 0.f;
            }
        }
        std::memcpy(d.r + i, block.r, sizeof block.r);
        std::memcpy(d.g + i, block.g, sizeof block.g);
        std::memcpy(d.b + i, block.b, sizeof block.b);
    }
}

}  // namespace

void reflect_directions(const LobeConstants& lobe, const ReflectedDirections& directions, size_t n, Isa isa) {
    variant_of<reflect_body>(isa)(lobe, directions, n);
}

}  // namespace viscache

#include "viscache/scene/bsdf.h"

namespace viscache {

namespace {

bool above(const ShadingPoint& sp, Vec3 w) { return dot(sp.ns, w) > 0 && dot(sp.ng, w) > 0; }

/// Share of the diffuse part: what the specular layer does not reflect towards the eye. Keeps the sum ≤ 1.
Rgb diffuse_part(const ShadingPoint& sp) {
    if (sp.kind != MaterialKind::kGlossy) return sp.base;
    return sp.base * (Rgb{1, 1, 1} - schlick(sp.specular, dot(sp.ns, sp.wo)));
}

/// Probability of sampling the glossy lobe.
float glossy_share(const ShadingPoint& sp) {
    if (sp.kind != MaterialKind::kGlossy) return 0;
    const float glossy = luminance(schlick(sp.specular, dot(sp.ns, sp.wo))), diffuse = luminance(diffuse_part(sp));
    return glossy + diffuse > 0 ? glossy / (glossy + diffuse) : 0.f;
}

}  // namespace

Rgb eval_bsdf(const ShadingPoint& sp, Vec3 wi) {
    if (!above(sp, wi) || !above(sp, sp.wo)) return {};
    Rgb f = diffuse_part(sp) / kPi;
    if (sp.kind == MaterialKind::kGlossy) {
        const Vec3 h = normalize(wi + sp.wo);
        const float cos_i = dot(sp.ns, wi), cos_o = dot(sp.ns, sp.wo);
        const float lobe = ggx_d(dot(sp.ns, h), sp.roughness) * smith_g2(cos_i, cos_o, sp.roughness) / (4 * cos_i * cos_o);
        f += schlick(sp.specular, dot(wi, h)) * lobe;
    }
    return f;
}

float pdf_bsdf(const ShadingPoint& sp, Vec3 wi) {
    if (!above(sp, wi) || !above(sp, sp.wo)) return 0;
    const float share = glossy_share(sp);
    float pdf = (1 - share) * dot(sp.ns, wi) / kPi;
    if (share > 0) {
        const Frame3 frame = frame_around(sp.ns);
        const Vec3 h = normalize(wi + sp.wo), wo = frame.to_local(sp.wo);
        pdf += share * pdf_ggx_vndf(wo, frame.to_local(h), sp.roughness) / (4 * std::max(1e-12f, dot(sp.wo, h)));
    }
    return pdf;
}

std::optional<BsdfSample> sample_bsdf(const ShadingPoint& sp, float u_lobe, Vec2 u) {
    const Frame3 frame = frame_around(sp.ns);
    Vec3 wi;
    if (u_lobe < glossy_share(sp)) {
        const Vec3 wo = frame.to_local(sp.wo);
        if (!(wo.z > 0)) return std::nullopt;
        const Vec3 h = sample_ggx_vndf(wo, sp.roughness, u);
        wi = frame.to_world(h * (2 * dot(wo, h)) - wo);
    } else {
        wi = frame.to_world(square_to_cosine_hemisphere(u));
    }
    const float pdf = pdf_bsdf(sp, wi);
    if (!(pdf > 0)) return std::nullopt;
    return BsdfSample{wi, eval_bsdf(sp, wi) * (dot(sp.ns, wi) / pdf), pdf};
}

}  // namespace viscache

#include "viscache/scene/bsdf.h"

namespace viscache {

namespace {

bool above(const ShadingPoint& sp, Vec3 w) { return dot(sp.ns, w) > 0 && dot(sp.ng, w) > 0; }

bool reflects(const ShadingPoint& sp, Vec3 wi) {
    return (sp.kind == MaterialKind::kDiffuse || sp.kind == MaterialKind::kGlossy) && above(sp, wi) &&
           above(sp, sp.wo);
}

/// Fresnel term of the glossy lobe.
Rgb lobe_fresnel(const ShadingPoint& sp, float cos) {
    if (sp.coat) return sp.specular * fresnel_outside(cos, sp.coat->eta);
    return sp.metal ? sp.specular * fresnel_conductor(*sp.metal, cos) : schlick(sp.specular, cos, sp.mix.f90);
}

/// Mean of 1 − F' at the half vectors of diffuse light: the mean of Schlick's (1 − cos_h)⁵, cosine-weighted
/// over the hemisphere, is a function of cos_o, here a polynomial to 1.1e-5.
float mix_left(const FresnelMix& mix, float cos_o) {
    const float m = 1 - cos_o;
    const float mean = 8.3e-5f + m * (2.0078e-3f + m * (9.38195e-3f + m * (7.67217e-3f + m * 9.02115e-3f)));
    return 1 - mix.taken - (mix.taken90 - mix.taken) * mean;
}

/// Fraction of the light that the Fresnel term of the glossy lobe leaves to the diffuse part, towards an eye
/// at cosine cos_o.
Rgb under_lobe(const ShadingPoint& sp, float cos_o) {
    if (sp.kind != MaterialKind::kGlossy) return sp.base;
    if (sp.coat) return coated_base(*sp.coat, sp.base) * transmitted(sp.coat->transmittance.data(), cos_o);
    if (sp.mix.on) return sp.base * mix_left(sp.mix, cos_o);
    return sp.base * (Rgb{1, 1, 1} - schlick(sp.specular, cos_o));
}

constexpr float kEntry =
    1.047f;  // entry factor of the diffuse part under a lobe; its mean albedo is 20/21 of this

/// Proportional to 1 − F(cos_i). A factor of 21/20 would make its cosine-weighted mean one. The factor is
/// 0.3 % smaller, because the albedo of the lobe exceeds F(cos_o) by up to 0.26 % (F0 = 0, roughness 0.15,
/// cos_o = 0.63); this keeps the sum of both parts below one.
float diffuse_entry(const ShadingPoint& sp, float cos_i) {
    if (sp.kind != MaterialKind::kGlossy) return 1;
    if (sp.coat) return transmitted(sp.coat->transmittance.data(), cos_i);
    return kEntry * (1 - schlick(Rgb{}, cos_i).x);
}

/// Cosine-weighted mean of `diffuse_entry`, for a glossy surface.
float mean_entry(const ShadingPoint& sp) {
    return sp.mix.on ? 1 : sp.coat ? sp.coat->mean : kEntry * 20 / 21;
}

}  // namespace

float lobe_g1(const ShadingPoint& sp, float cos) {
    return sp.beckmann ? beckmann_g1(cos, sp.roughness) : smith_g1(cos, sp.roughness);
}

float glossy_share(const ShadingPoint& sp) {
    if (sp.kind != MaterialKind::kGlossy) return 0;
    const float cos_o = dot(sp.ns, sp.wo);
    const float glossy = luminance(lobe_fresnel(sp, cos_o));
    const float diffuse = luminance(under_lobe(sp, cos_o)) * (sp.coat ? sp.coat->mean : 1.f);
    return glossy > 0 ? glossy / (glossy + diffuse) : 0.f;
}

namespace {

struct Reflection {
    Rgb f;
    float pdf = 0;
};

/// f and density of one direction. Both are computed from the same numbers, so that their quotient is
/// smooth.
Reflection reflect(const ShadingPoint& sp, Vec3 wi) {
    if (!reflects(sp, wi)) return {};
    const float cos_i = dot(sp.ns, wi), cos_o = dot(sp.ns, sp.wo), share = glossy_share(sp);
    Reflection r{{}, (1 - share) * cos_i / kPi};
    if (!sp.mix.on) r.f = under_lobe(sp, cos_o) * (diffuse_entry(sp, cos_i) / kPi);
    if (sp.kind == MaterialKind::kGlossy) {
        const Vec3 h = normalize(wi + sp.wo), local = frame_around(sp.ns).to_local(h);
        const float d = sp.beckmann ? beckmann_d(local, sp.roughness) : ggx_d(local, sp.roughness);
        const float seen = lobe_g1(sp, cos_o),
                    shadowed = d / (4 * cos_i * cos_o) * (lobe_g1(sp, cos_i) * seen);
        if (sp.mix.on) r.f = sp.base * (sp.mix.left(dot(wi, h)) / kPi);
        r.f += lobe_fresnel(sp, dot(wi, h)) * shadowed;
        // Density of the normal h, visible or any, times dω_h/dω_i = 1 / (4 cos(wo, h))
        r.pdf += sp.beckmann ? share * d * local.z / (4 * dot(sp.wo, h)) : share * d * seen / (4 * cos_o);
    }
    return r;
}

}  // namespace

Rgb diffuse_albedo(const ShadingPoint& sp) {
    if (!above(sp, sp.wo)) return {};
    if (sp.kind != MaterialKind::kGlossy) return sp.kind == MaterialKind::kDiffuse ? sp.base : Rgb{};
    return under_lobe(sp, dot(sp.ns, sp.wo)) * mean_entry(sp);
}

Rgb eval_bsdf(const ShadingPoint& sp, Vec3 wi) { return reflect(sp, wi).f; }

float pdf_bsdf(const ShadingPoint& sp, Vec3 wi) { return reflect(sp, wi).pdf; }

GlassShares glass_shares(const ShadingPoint& sp, float cos) {
    if (sp.mix.on) {
        // The lobe of a glossy sheet reflects, no mirror
        const Rgb f = schlick(sp.specular, std::fabs(cos), sp.mix.f90);
        return {sp.kind == MaterialKind::kDielectric ? f : Rgb{},
                sp.transmission * std::max(0.f, sp.mix.left(std::fabs(cos)))};
    }
    const float f = sp.thin ? plate_reflectance(cos, sp.eta) : fresnel_dielectric(cos, sp.eta);
    return {{f, f, f}, sp.transmission * (1 - f)};
}

float sheet_share(const ShadingPoint& sp) {
    const float cos_o = dot(sp.ns, sp.wo), passed = luminance(glass_shares(sp, cos_o).passed);
    const float rest = luminance(lobe_fresnel(sp, cos_o)) + luminance(under_lobe(sp, cos_o));
    return passed > 0 ? passed / (passed + rest) : 0.f;
}

std::optional<BsdfSample> sample_bsdf(const ShadingPoint& sp, float u_lobe, Vec2 u) {
    if (!above(sp, sp.wo)) return std::nullopt;
    const Frame3 frame = frame_around(sp.ns);
    Vec3 local;
    if (u_lobe < glossy_share(sp)) {
        const Vec3 wo = frame.to_local(sp.wo);
        const Vec3 h = sp.beckmann ? sample_beckmann(sp.roughness, u)
                                   : sample_ggx_vndf({wo.x, wo.y, std::max(wo.z, 1e-6f)}, sp.roughness, u);
        local = h * (2 * dot(wo, h)) - wo;
    } else {
        local = square_to_cosine_hemisphere(u);
    }
    const Vec3 wi = normalize(frame.to_world(local));
    const Reflection r = reflect(sp, wi);
    if (!(r.pdf > 0)) return std::nullopt;
    return BsdfSample{wi, r.f * (dot(sp.ns, wi) / r.pdf), r.pdf};
}

}  // namespace viscache

#pragma once
// Reflection of diffuse and glossy materials. Mirrors and glass are followed by rays, not evaluated: they
// return zero here.
#include <optional>

#include "viscache/sampling/warp.h"
#include "viscache/scene/coat.h"

namespace viscache {

/// How a lobe takes from the base what it reflects at the half vector (`CoatKind::kFresnelMix`).
struct FresnelMix {
    bool on = false;
    float f90 = 1;  ///< reflectance of the lobe at grazing incidence
    float taken = 0,
          taken90 = 1;  ///< share of the base's light that it takes, at normal and grazing incidence

    float left(float cos) const { return 1 - taken - (taken90 - taken) * schlick_weight(cos); }
};

/// What reflection needs at a point. The normals and `wo` are unit vectors on the same side of the surface.
struct ShadingPoint {
    Vec3 ng, ns, wo;
    Rgb base, specular;
    float roughness = 0.1f;
    MaterialKind kind = MaterialKind::kDiffuse;
    float eta = 1.5f;
    const Coat* coat = nullptr;        ///< of a glossy surface; nullptr: none
    const Conductor* metal = nullptr;  ///< of a mirror or of a glossy surface without a base; nullptr: none
    bool beckmann = false;             ///< microfacets are Beckmann's, not GGX's
    bool mirror = false;               ///< the lobe stands for the mirror of a smooth coat
    bool thin = false;                 ///< a dielectric or a glossy sheet without thickness
    FresnelMix mix{};
    Rgb transmission{1, 1, 1};  ///< factor of the light that passes glass or a glossy sheet
};

/// True if the surface reflects no light at all.
inline bool is_black(const ShadingPoint& sp) {
    return !(max_component(sp.base) > 0) &&
           !(sp.kind == MaterialKind::kGlossy && max_component(sp.specular) > 0);
}

/// True if a lobe may reflect light beside the diffuse part.
inline bool has_lobe(const ShadingPoint& sp) {
    return sp.kind == MaterialKind::kGlossy && max_component(sp.specular) > 0;
}

/// f(wo, wi) without the cosine, per steradian; symmetric in wo and wi; zero below either normal. Diffuse:
/// base/π. Glossy: a lobe of GGX's or Beckmann's microfacets with Schlick's Fresnel term F of `specular` =
/// F0, plus the diffuse part below it (Shirley et al. 1997), base/π · 1.047 (1 − F0)(1 − (1 − cos_o)⁵)(1 − (1
/// − cos_i)⁵), whose albedo is 0.997 base (1 − F(cos_o)). Under a coat: the lobe with the Fresnel term of the
/// dielectric, times `specular`, plus coated_base/π · T(cos_o) T(cos_i). Of a metal: the lobe with the
/// Fresnel term of its index, times `specular`. Of a Fresnel mix: the lobe with Schlick's F between
/// `specular` and `f90` at the half vector h, plus base/π · (1 − F'(h)), as glTF 2.0 defines it (appendix B):
/// F' is the largest channel of F without metal. If base, F0 and `specular` are at most 1, the surface
/// reflects no more light than arrives. (But a Fresnel mix of low roughness does at grazing angles: glTF's
/// formula gives 1.9 for a white base seen along the surface, and 1.04 on average. Two corners: 0.7 % more at
/// roughness 0.001 and grazing angles, 2 % more under a Beckmann coat of index below 1.)
Rgb eval_bsdf(const ShadingPoint& sp, Vec3 wi);
/// Density of `sample_bsdf` per solid angle. Integrates to one minus the probability of an empty sample.
float pdf_bsdf(const ShadingPoint& sp, Vec3 wi);

/// Albedo of the diffuse part alone for light from wo: base, or 0.997 base (1 − F(cos_o)) under a glossy
/// lobe, or what leaves through a coat, or what a Fresnel mix leaves.
Rgb diffuse_albedo(const ShadingPoint& sp);

/// Fraction of the microfacets visible from a direction.
float lobe_g1(const ShadingPoint& sp, float cos);

/// Probability that `sample_bsdf` samples the glossy lobe.
float glossy_share(const ShadingPoint& sp);

/// Light that meets glass or a glossy sheet at a cosine (its sign tells the side of glass): what is mirrored
/// as by a mirror, and what passes.
struct GlassShares {
    Rgb mirrored, passed;
};
GlassShares glass_shares(const ShadingPoint& sp, float cos);
float sheet_share(const ShadingPoint& sp);  ///< `pass_share` of a sheet
/// Probability with which a path from `wo` passes a glossy sheet; 0 for all other surfaces.
inline float pass_share(const ShadingPoint& sp) {
    return sp.kind == MaterialKind::kGlossy && sp.thin ? sheet_share(sp) : 0.f;
}

struct BsdfSample {
    Vec3 wi;
    Rgb weight;  ///< f·cos/pdf
    float pdf;
};
/// Chooses a lobe by the luminance of its albedo. Empty if the direction lies below the surface.
std::optional<BsdfSample> sample_bsdf(const ShadingPoint& sp, float u_lobe, Vec2 u);

}  // namespace viscache

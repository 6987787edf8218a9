#pragma once
// Reflection of diffuse and glossy materials. Mirrors and glass are followed by rays, not evaluated: they
// return zero here.
#include <optional>

#include "viscache/sampling/warp.h"
#include "viscache/scene/material.h"

namespace viscache {

/// What reflection needs at a point. The normals and `wo` are unit vectors on the same side of the surface.
struct ShadingPoint {
    Vec3 ng, ns, wo;
    Rgb base, specular;
    float roughness = 0.1f;
    MaterialKind kind = MaterialKind::kDiffuse;
    float eta = 1.5f;
};

/// True if the surface reflects no light at all.
inline bool is_black(const ShadingPoint& sp) {
    return !(max_component(sp.base) > 0) &&
           !(sp.kind == MaterialKind::kGlossy && max_component(sp.specular) > 0);
}

/// f(wo, wi) without the cosine, per steradian; symmetric in wo and wi; zero below either normal. Diffuse:
/// base/π. Glossy: a GGX lobe with Schlick's Fresnel term F of `specular` = F0, plus the diffuse part below
/// it (Shirley et al. 1997), base/π · 1.047 (1 − F0)(1 − (1 − cos_o)⁵)(1 − (1 − cos_i)⁵), whose albedo is
/// 0.997 base (1 − F(cos_o)). If base and F0 are at most 1, the surface reflects no more light than arrives.
Rgb eval_bsdf(const ShadingPoint& sp, Vec3 wi);
/// Density of `sample_bsdf` per solid angle. Integrates to one minus the probability of an empty sample.
float pdf_bsdf(const ShadingPoint& sp, Vec3 wi);

/// Albedo of the diffuse part alone for light from wo: base, or 0.997 base (1 − F(cos_o)) under a glossy
/// lobe.
Rgb diffuse_albedo(const ShadingPoint& sp);

/// Probability that `sample_bsdf` samples the glossy lobe.
float glossy_share(const ShadingPoint& sp);

struct BsdfSample {
    Vec3 wi;
    Rgb weight;  ///< f·cos/pdf
    float pdf;
};
/// Chooses a lobe by the luminance of its albedo. Empty if the direction lies below the surface.
std::optional<BsdfSample> sample_bsdf(const ShadingPoint& sp, float u_lobe, Vec2 u);

}  // namespace viscache

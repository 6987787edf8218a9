#pragma once
// Reflection of diffuse and glossy materials. Mirrors and glass are followed, not evaluated.
#include <optional>

#include "viscache/sampling/warp.h"
#include "viscache/scene/material.h"

namespace viscache {

/// What reflection needs at a point; normals and `wo` are unit and lie on one side.
struct ShadingPoint {
    Vec3 ng, ns, wo;
    Rgb base, specular;
    float roughness = 0.1f;
    MaterialKind kind = MaterialKind::kDiffuse;
    float eta = 1.5f;
};

/// f(wo, wi) without the cosine, per steradian; zero below either normal.
Rgb eval_bsdf(const ShadingPoint& sp, Vec3 wi);
/// Density of `sample_bsdf`, per solid angle.
float pdf_bsdf(const ShadingPoint& sp, Vec3 wi);

struct BsdfSample {
    Vec3 wi;
    Rgb weight;  ///< f·cos/pdf
    float pdf;
};
/// Lobes chosen by luminance. Empty: the direction fell below the surface.
std::optional<BsdfSample> sample_bsdf(const ShadingPoint& sp, float u_lobe, Vec2 u);

}  // namespace viscache

#pragma once
// Samplers and their densities. Local frames have z along the normal.
#include <optional>

#include "viscache/math/frame.h"

namespace viscache {

/// Sine and cosine of a in [−π/4, π/4], accurate to two units in the last place (the polynomials of Cephes).
/// Only arithmetic, so that loops over them vectorise.
inline float sin_eighth(float a) {
    const float s = a * a;
    return a + a * s * (-1.6666654611e-1f + s * (8.3321608736e-3f - s * 1.9515295891e-4f));
}
inline float cos_eighth(float a) {
    const float s = a * a;
    return 1 - 0.5f * s + s * s * (4.166664568e-2f + s * (-1.388731625e-3f + s * 2.443315712e-5f));
}

/// Uniform on the unit disk, concentric (Shirley and Chiu 1997); density 1/π per area. Branch-free, because
/// random numbers would mispredict branches.
inline Vec2 square_to_disk_concentric(Vec2 u) {
    const float x = 2 * u.x - 1, y = 2 * u.y - 1;
    const bool wide = std::fabs(x) > std::fabs(y);
    // The larger coordinate is the radius, the ratio of both is the angle in [−π/4, π/4].
    const float r = wide ? x : y, other = wide ? y : x;
    // At the centre the angle does not matter, but 0 / 0 must not occur.
    const float a = (kPi / 4) * (other / (r == 0 ? 1 : r)), c = cos_eighth(a), s = sin_eighth(a);
    return {r * (wide ? c : s), r * (wide ? s : c)};
}

/// Cosine-weighted on the hemisphere around +z; density `pdf_cosine_hemisphere` per solid angle.
inline Vec3 square_to_cosine_hemisphere(Vec2 u) {
    const Vec2 d = square_to_disk_concentric(u);
    return {d.x, d.y, std::sqrt(std::max(0.f, 1 - d.x * d.x - d.y * d.y))};
}
inline float pdf_cosine_hemisphere(Vec3 w) { return std::max(0.f, w.z) / kPi; }

/// Uniform on the hemisphere around +z; density 1/(2π) per solid angle. Equal areas of the disk become equal
/// solid angles.
inline Vec3 square_to_uniform_hemisphere(Vec2 u) {
    const Vec2 d = square_to_disk_concentric(u);
    const float r2 = d.x * d.x + d.y * d.y, scale = std::sqrt(std::max(0.f, 2 - r2));
    return {d.x * scale, d.y * scale, std::max(0.f, 1 - r2)};
}
inline float pdf_uniform_hemisphere() { return 1 / (2 * kPi); }

/// Uniform on the sphere; density 1/(4π) per solid angle.
inline Vec3 square_to_uniform_sphere(Vec2 u) {
    // sin θ for cos θ = 1 − 2u, without the cancellation of 1 − cos² θ
    const float r = 2 * std::sqrt(u.x * (1 - u.x)), phi = 2 * kPi * u.y;
    return {r * std::cos(phi), r * std::sin(phi), 1 - 2 * u.x};
}
inline float pdf_uniform_sphere() { return 1 / (4 * kPi); }

/// Uniform in a triangle: barycentric weights of vertices 1 and 2; vertex 0 has the rest. Density 1/area per
/// area.
inline Vec2 square_to_triangle(Vec2 u) {
    // The part of the triangle beyond the weight 1 − s is a fraction s² of its area: hence the root.
    const float s = std::sqrt(1 - u.x);
    return {1 - s, u.y * s};
}

/// Uniform in the cone of cosine ≥ cos_max < 1 around +z; density `pdf_uniform_cone` per solid angle.
inline Vec3 square_to_uniform_cone(Vec2 u, float cos_max) {
    // t = 1 − cosθ keeps the sine accurate in narrow cones
    const float t = u.x * (1 - cos_max), r = std::sqrt(t * (2 - t)), phi = 2 * kPi * u.y;
    return {r * std::cos(phi), r * std::sin(phi), 1 - t};
}
inline float pdf_uniform_cone(float cos_max) { return 1 / (2 * kPi * (1 - cos_max)); }

struct SphereLightSample {
    Vec3 p, n;              ///< point on the sphere and its outward normal
    float pdf_solid_angle;  ///< density per solid angle at `from`
    float pdf_area;         ///< the same density per area of the sphere
};
/// Samples the part of a sphere that is visible from `from`, uniformly in its solid angle. Empty unless
/// `from` is outside the sphere. Computed in double: stable for distant spheres and for points just above
/// the surface.
inline std::optional<SphereLightSample> sample_sphere_light(Vec3 center, float radius, Vec3 from, Vec2 u) {
    const double x = double(center.x) - from.x, y = double(center.y) - from.y, z = double(center.z) - from.z;
    const double d = std::sqrt(x * x + y * y + z * z), r = radius;
    if (!(r > 0 && d > r)) return std::nullopt;
    // 1 − cosθ of the cone and of the sample, computed without cancellation
    const double sin_max = r / d, sin2_max = sin_max * sin_max;
    const double cone = sin2_max / (1 + std::sqrt(1 - sin2_max)), t = u.x * cone;
    const double cos_theta = 1 - t, sin2_theta = t * (2 - t);
    // γ is the angle at the sphere between its normal and the direction back; α is the angle at the centre
    // between the axis and the point
    const double cos_gamma = std::sqrt(std::max(0.0, 1 - sin2_theta / sin2_max));
    // α = γ − θ, where sin γ = sin θ / sin θ_max by the law of sines
    const double cos_alpha = std::min(1.0, sin2_theta / sin_max + cos_theta * cos_gamma);
    const double sin_alpha = std::sqrt(1 - cos_alpha * cos_alpha), phi = 2 * M_PI * u.y;
    const Frame3 frame = frame_around({float(-x / d), float(-y / d), float(-z / d)});
    const Vec3 n = normalize(frame.to_world(
        {float(sin_alpha * std::cos(phi)), float(sin_alpha * std::sin(phi)), float(cos_alpha)}));
    // The near and the far intersection have the product d² − r². Divided by the far one, nothing cancels.
    const double distance = (d - r) * (d + r) / (d * cos_theta + r * cos_gamma);
    const double pdf = 1 / (2 * M_PI * cone);
    return SphereLightSample{center + n * radius, n, float(pdf),
                             float(pdf * cos_gamma / (distance * distance))};
}

// Microfacets (GGX, isotropic; Walter et al. 2007). alpha is in [1e-3, 1].

/// Density of the microfacet normal h (local frame); D·cos integrates to 1 over the hemisphere. Computed
/// from the tangent rather than the cosine, which stays accurate down to alpha = 1e-3.
inline float ggx_d(Vec3 h, float alpha) {
    if (!(h.z > 0)) return 0;
    const float a2 = alpha * alpha, t = (h.x * h.x + h.y * h.y) / a2 + h.z * h.z;
    return 1 / (kPi * a2 * t * t);
}
/// Fraction of the microfacets visible from a direction with cosine cos_w; 0 from below.
inline float smith_g1(float cos_w, float alpha) {
    if (!(cos_w > 0)) return 0;
    const float c2 = cos_w * cos_w, tan2 = std::max(0.f, 1 - c2) / c2;
    return 2 / (1 + std::sqrt(1 + alpha * alpha * tan2));
}
/// Separable masking and shadowing, as in Mitsuba 3.
inline float smith_g2(float cos_i, float cos_o, float alpha) {
    return smith_g1(cos_i, alpha) * smith_g1(cos_o, alpha);
}

/// Microfacet normal visible from wo, wo.z > 0 (Heitz 2018); density `pdf_ggx_vndf` per solid angle of h.
inline Vec3 sample_ggx_vndf(Vec3 wo, float alpha, Vec2 u) {
    // Stretch the surface to a hemisphere, where the visible part is that of a sphere seen from v.
    const Vec3 v = normalize({alpha * wo.x, alpha * wo.y, wo.z});
    const float l2 = v.x * v.x + v.y * v.y;
    const Vec3 t1 = l2 > 0 ? Vec3{-v.y, v.x, 0} / std::sqrt(l2) : Vec3{1, 0, 0}, t2 = cross(v, t1);
    // A uniform point of the disk; s shifts it to the part of the projected hemisphere that v sees.
    const float r = std::sqrt(u.x), phi = 2 * kPi * u.y, a = r * std::cos(phi), s = 0.5f * (1 + v.z);
    const float b = (1 - s) * std::sqrt(std::max(0.f, 1 - a * a)) + s * r * std::sin(phi);
    const Vec3 h = t1 * a + t2 * b + v * std::sqrt(std::max(0.f, 1 - a * a - b * b));
    // Unstretch: normals transform by the inverse transpose.
    return normalize({alpha * h.x, alpha * h.y, std::max(0.f, h.z)});
}
inline float pdf_ggx_vndf(Vec3 wo, Vec3 h, float alpha) {
    return wo.z > 0 ? smith_g1(wo.z, alpha) * ggx_d(h, alpha) * std::max(0.f, dot(wo, h)) / wo.z : 0.f;
}

// The same for Beckmann's distribution.

inline float beckmann_d(Vec3 h, float alpha) {
    if (!(h.z > 0)) return 0;
    const float a2 = alpha * alpha, c2 = h.z * h.z;
    return std::exp(-(h.x * h.x + h.y * h.y) / (a2 * c2)) / (kPi * a2 * c2 * c2);
}
/// The rational fit of Walter et al. 2007.
inline float beckmann_g1(float cos_w, float alpha) {
    if (!(cos_w > 0)) return 0;
    const float a = cos_w / (alpha * std::sqrt(std::max(1e-12f, 1 - cos_w * cos_w)));
    return a >= 1.6f ? 1.f : (3.535f * a + 2.181f * a * a) / (1 + 2.276f * a + 2.577f * a * a);
}
/// Microfacet normal; density D·cos per solid angle of h.
inline Vec3 sample_beckmann(float alpha, Vec2 u) {
    const float tan = alpha * std::sqrt(-std::log1p(-u.x)), phi = 2 * kPi * u.y;
    return normalize({tan * std::cos(phi), tan * std::sin(phi), 1});
}

/// (1 − cos)⁵, with which Schlick's approximation goes from normal to grazing incidence.
inline float schlick_weight(float cos) {
    const float m = std::clamp(1 - cos, 0.f, 1.f);
    return m * m * m * m * m;
}
/// Schlick's approximation of the Fresnel reflectance, from the reflectance at normal incidence.
inline Rgb schlick(Rgb f0, float cos, float f90 = 1) {
    return f0 + (Rgb{f90, f90, f90} - f0) * schlick_weight(cos);
}
/// Unpolarised reflectance of a smooth dielectric; 1 at total internal reflection. cos_i > 0 is outside,
/// cos_i < 0 is inside. eta = interior index of refraction over exterior index.
inline float fresnel_dielectric(float cos_i, float eta) {
    const float n = cos_i >= 0 ? eta : 1 / eta, c = std::min(1.f, std::fabs(cos_i));
    const float sin2_t = (1 - c * c) / (n * n);
    if (sin2_t >= 1) return 1;
    const float t = std::sqrt(1 - sin2_t);
    const float s = (c - n * t) / (c + n * t), p = (n * c - t) / (n * c + t);
    return 0.5f * (s * s + p * p);
}
/// Reflectance of a plate without thickness, with all reflections between its two sides:
/// F + (1 − F)² F / (1 − F²) = 2F / (1 + F).
inline float plate_reflectance(float cos, float eta) {
    const float f = fresnel_dielectric(std::fabs(cos), eta);
    return 2 * f / (1 + f);
}
/// Refracted direction for `wo` on the side of `n`. eta_ratio = index on wo's side over the index on the
/// other side: 1/eta from outside, eta from inside. Empty at total internal reflection.
inline std::optional<Vec3> refract(Vec3 wo, Vec3 n, float eta_ratio) {
    const float cos_i = dot(wo, n), sin2_t = eta_ratio * eta_ratio * std::max(0.f, 1 - cos_i * cos_i);
    if (sin2_t >= 1) return std::nullopt;
    return n * (eta_ratio * cos_i - std::sqrt(1 - sin2_t)) - wo * eta_ratio;
}

}  // namespace viscache

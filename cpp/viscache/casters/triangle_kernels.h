#pragma once
// Intersection of one ray with one triangle: in the layout of the thesis of Wald, which the tracers of the
// paper use, and by a watertight test. Both find hits with t_min < t <= limit. `NearestHit` and callers of
// any-hit rays exclude t_max itself.
#include <array>
#include <cstdint>

#include "viscache/visibility/parameter_row.h"
#include "viscache/visibility/query.h"
#include "viscache/visibility/ray_caster.h"

namespace viscache {

/// One coordinate, selected at run time.
inline float component(const Vec3& v, uint32_t axis) {
    static_assert(sizeof(Vec3) == 3 * sizeof(float));
    return reinterpret_cast<const float*>(&v)[axis];
}

enum class TriangleKernel {
    kWatertight,  ///< no ray passes between two triangles that share an edge
    kWald,        ///< as in the paper: fewer operations, may miss one ray in a million at an edge
};

template <>
inline constexpr std::array kNames<TriangleKernel>{"watertight", "wald"};

/// A hit; u and v are the barycentric coordinates of vertices 1 and 2.
struct TriangleHit {
    float t = kInfinity, u = 0, v = 0;
};

/// The nearest of all hits offered, in any order. Of hits at the same t, the lowest id wins. Starts with the
/// end of the ray, which is not a hit itself.
struct NearestHit {
    float t;
    uint32_t id = kNoHit;
    float u = 0, v = 0;

    /// Returns false if the hit changes nothing.
    bool nearer(const TriangleHit& hit, uint32_t other) const {
        return hit.t < t || (hit.t == t && id != kNoHit && other < id);
    }
    void take(const TriangleHit& hit, uint32_t other) {
        t = hit.t;
        id = other;
        u = hit.u;
        v = hit.v;
    }
};

/// 48 bytes: the plane divided by the dominant component of the normal, and two barycentric coordinates as
/// linear functions of the other two coordinates of the hit [Wald, PhD thesis 2004, 7.1].
struct WaldTriangle {
    float n_u, n_v, n_d;
    uint32_t axis;        ///< dominant axis; u and v are the next two, cyclically
    float b_u, b_v, b_d;  ///< barycentric coordinate of vertex 1
    uint32_t id;
    float c_u, c_v, c_d;  ///< barycentric coordinate of vertex 2
    uint32_t unused;
};
static_assert(sizeof(WaldTriangle) == 48);

/// Data of a triangle, computed in double. A triangle without area is never hit.
WaldTriangle wald_triangle(Vec3 a, Vec3 b, Vec3 c, uint32_t id);

inline bool intersect_wald(const WaldTriangle& tri, const Ray& ray, float limit, TriangleHit& hit) {
    constexpr uint32_t kNext[5] = {0, 1, 2, 0, 1};
    const uint32_t k = tri.axis, u = kNext[k + 1], v = kNext[k + 2];
    const float towards = component(ray.d, k) + tri.n_u * component(ray.d, u) + tri.n_v * component(ray.d, v);
    const float t =
        (tri.n_d - component(ray.o, k) - tri.n_u * component(ray.o, u) - tri.n_v * component(ray.o, v)) /
        towards;
    if (!(t > ray.t_min && t <= limit)) return false;
    const float at_u = component(ray.o, u) + t * component(ray.d, u),
                at_v = component(ray.o, v) + t * component(ray.d, v);
    const float beta = at_u * tri.b_u + at_v * tri.b_v + tri.b_d;
    const float gamma = at_u * tri.c_u + at_v * tri.c_v + tri.c_d;
    if (!(beta >= 0 && gamma >= 0 && beta + gamma <= 1)) return false;
    hit = {t, beta, gamma};
    return true;
}

/// Data of a ray for the watertight test: the ray sheared along its dominant axis [Woop, Benthin, Wald
/// 2013].
struct ShearedRay {
    Vec3 o, d;                   ///< of the ray itself
    float o_x, o_y, o_z, t_min;  ///< in the order of the axes below
    float s_x, s_y;
    uint32_t x, y, z;  ///< axis indices; z is the dominant axis, x and y keep the winding

    explicit ShearedRay(const Ray& ray);
};

/// Corners of a triangle; also 48 bytes.
struct WatertightTriangle {
    Vec3 a, b, c;
    uint32_t id;
    uint32_t unused[2];
};
static_assert(sizeof(WatertightTriangle) == 48);

/// Where the ray meets the plane of the triangle, in double. Mean depths of the corners would cancel: at a
/// point that a ray leaves, they are wrong by ulps of the triangle's size, for floors along the axes too. Not
/// finite where the ray lies in the plane.
float plane_distance(const WatertightTriangle& tri, const ShearedRay& ray);

/// The test of the edges in double, for rays within rounding error of an edge and for triangles whose
/// products leave single precision. It uses the corners as sheared in single precision, so that neighbouring
/// triangles agree.
bool within_in_double(const std::array<float, 6>& sheared, TriangleHit& hit);

/// Neighbouring triangles compute a shared edge from the same two corners with products that differ only in
/// sign (floating-point contraction is off), so a ray cannot lie outside both.
inline bool intersect_watertight(const WatertightTriangle& tri, const ShearedRay& ray, float limit,
                                 TriangleHit& hit) {
    const float az = component(tri.a, ray.z) - ray.o_z, bz = component(tri.b, ray.z) - ray.o_z,
                cz = component(tri.c, ray.z) - ray.o_z;
    const float ax = component(tri.a, ray.x) - ray.o_x - ray.s_x * az,
                ay = component(tri.a, ray.y) - ray.o_y - ray.s_y * az;
    const float bx = component(tri.b, ray.x) - ray.o_x - ray.s_x * bz,
                by = component(tri.b, ray.y) - ray.o_y - ray.s_y * bz;
    const float cx = component(tri.c, ray.x) - ray.o_x - ray.s_x * cz,
                cy = component(tri.c, ray.y) - ray.o_y - ray.s_y * cz;
    const float u = cx * by - cy * bx, v = ax * cy - ay * cx, w = bx * ay - by * ax;
    const float det = u + v + w;
    // Smaller products may have lost digits to underflow
    constexpr float kSmall = 1e-30f;
    TriangleHit at;
    if (u == 0 || v == 0 || w == 0 || !(std::fabs(det) > kSmall)) {
        if (!within_in_double({ax, ay, bx, by, cx, cy}, at)) return false;
    } else {
        if ((u < 0 || v < 0 || w < 0) && (u > 0 || v > 0 || w > 0)) return false;
        const float inverse = 1 / det;
        at = {0, v * inverse, w * inverse};
    }
    at.t = plane_distance(tri, ray);
    if (!(at.t > ray.t_min && at.t <= limit && at.t < kInfinity)) return false;
    hit = at;
    return true;
}

}  // namespace viscache

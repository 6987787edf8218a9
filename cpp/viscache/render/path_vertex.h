#pragma once
// A vertex of a sub-path of bidirectional path tracing (Veach 1997, Sec. 10), and what connecting it takes.
//
// Shading normals: the integrand is that of tracing from the eye, f(eye → light)·|cos| to the shading normal
// on the eye's side of every edge, the geometric one on the other. Light paths carry the quotient of the two
// (Veach 1997, Sec. 5.3).
#include "viscache/scene/bsdf.h"

namespace viscache {

struct PathVertex {
    Vec3 position;  ///< unused at infinity
    ShadingPoint
        surface;         ///< wo: unit direction to the vertex before; normals on its side. Only ng for lights
    Rgb beta;            ///< throughput that arrives: product of all factors over densities
    double forward = 0;  ///< density of the own sub-path, per m² (at infinity per sr)
    double reverse = 0;  ///< density of a sub-path from the other side, given the vertices behind it
    /// P for the quantized cache (AQVC Sec. 3.4): per m², over the unfolded length since the last vertex that
    /// is no mirror and no glass; of the environment per sr.
    double density = 0;
    bool front = true;     ///< reached on the side of the triangle's normal
    bool connects = true;  ///< camera, light, diffuse or glossy
    bool infinite = false;
};

/// The vertex as reflection from `wo` sees it: a shading normal turned away from wo is bent back to the
/// geometric one.
inline ShadingPoint shading_from(const PathVertex& v, Vec3 wo) {
    ShadingPoint sp = v.surface;
    sp.wo = wo;
    if (dot(sp.ns, wo) <= 0) sp.ns = sp.ng;
    return sp;
}

/// f·|cos| to the shading normal, for light that arrives from `light` and leaves to `eye`.
inline Rgb reflected(const PathVertex& v, Vec3 eye, Vec3 light) {
    const ShadingPoint sp = shading_from(v, eye);
    return eval_bsdf(sp, light) * dot(sp.ns, light);
}

/// Density per sr with which a path that came from `from` goes on to `to`.
inline double scatter_pdf(const PathVertex& v, Vec3 from, Vec3 to) {
    return double(pdf_bsdf(shading_from(v, from), to));
}

/// A density per sr at `from` as one per m² at `to`; unchanged where `to` is at infinity.
inline double to_area(double pdf, const PathVertex& from, const PathVertex& to) {
    if (to.infinite) return pdf;
    const Vec3 d = to.position - from.position;
    const double d2 = double(length2(d));
    return d2 > 0 ? pdf * std::fabs(double(dot(to.surface.ng, d))) / (d2 * std::sqrt(d2)) : 0;
}

}  // namespace viscache

#pragma once
// A vertex of a sub-path of bidirectional path tracing (Veach 1997, Sec. 10), with the data for connections.
//
// Shading normals: the integrand is that of path tracing from the eye, f(eye → light)·|cos|. The cosine uses
// the shading normal on the eye side of an edge and the geometric normal on the other side. Light paths carry
// the quotient of the two cosines (Veach 1997, Sec. 5.3).
#include "viscache/scene/bsdf.h"

namespace viscache {

struct PathVertex {
    Vec3 position;         ///< not used at infinity
    ShadingPoint surface;  ///< wo: unit, to the previous vertex; normals on its side; lights: ng only
    Rgb beta;              ///< throughput up to the vertex: product of factors over densities
    double forward = 0;    ///< density in its own sub-path, per m² (per sr at infinity)
    double reverse = 0;    ///< density in a sub-path from the other side, given the vertices behind it
    /// P of the quantized cache (AQVC Sec. 3.4): per m², over the unfolded length since the last vertex that
    /// is neither mirror nor glass. Per sr for the environment.
    double density = 0;
    bool front = true;     ///< hit on the side of the triangle normal
    bool connects = true;  ///< true for camera, light, diffuse and glossy vertices
    bool passed = false;   ///< the path has gone on as in a mirror, or through glass or a glossy sheet
    bool infinite = false;
};

/// The vertex for reflection from `wo`. A shading normal that faces away from wo is replaced by the geometric
/// normal.
inline ShadingPoint shading_from(const PathVertex& v, Vec3 wo) {
    ShadingPoint sp = v.surface;
    sp.wo = wo;
    if (dot(sp.ns, wo) <= 0) sp.ns = sp.ng;
    return sp;
}

/// f·|cos| with the shading normal, for light that arrives from `light` and leaves to `eye`.
/// The roles are those of the picture, whichever sub-path the vertex belongs to.
inline Rgb reflected(const PathVertex& v, Vec3 eye, Vec3 light) {
    const ShadingPoint sp = shading_from(v, eye);
    return eval_bsdf(sp, light) * dot(sp.ns, light);
}

/// Density per sr of the direction to `to` for a path that came from `from`.
inline double scatter_pdf(const PathVertex& v, Vec3 from, Vec3 to) {
    const ShadingPoint sp = shading_from(v, from);
    return double(pdf_bsdf(sp, to)) * (1 - double(pass_share(sp)));
}

/// Converts a density per sr at `from` to one per m² at `to`. It stays per sr if `to` is at infinity.
inline double to_area(double pdf, const PathVertex& from, const PathVertex& to) {
    // Nothing to convert: directions have no area
    if (to.infinite) return pdf;
    const Vec3 d = to.position - from.position;
    const double d2 = double(length2(d));
    // cos/d² with a d that is not normalised: dot/d³. In double, since these products make the
    // weights
    return d2 > 0 ? pdf * std::fabs(double(dot(to.surface.ng, d))) / (d2 * std::sqrt(d2)) : 0;
}

}  // namespace viscache

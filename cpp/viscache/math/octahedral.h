#pragma once
// Octahedral maps of the sphere.
#include <array>
#include <limits>

#include "viscache/math/vec.h"

namespace viscache {

template <class T>
T sign_not_zero(T v) {
    return v < 0 ? T(-1) : T(1);
}

/// Octahedral map [ED08] of a direction of any length into [0, 1]², computed in T. The zero vector maps to
/// the centre.
template <class T>
std::array<T, 2> octahedral_square(Vec3 d) {
    const T dx = d.x, dy = d.y, dz = d.z;
    // The smallest positive number instead of 0: the zero vector maps to the centre.
    const T l = std::max(std::fabs(dx) + std::fabs(dy) + std::fabs(dz), std::numeric_limits<T>::min());
    T x = dx / l, y = dy / l;
    // The lower half: the four outer triangles of the square, folded outwards over the edges of the diamond.
    if (dz < 0) {
        const T fold = (1 - std::fabs(y)) * sign_not_zero(x);
        y = (1 - std::fabs(x)) * sign_not_zero(y);
        x = fold;
    }
    return {T(0.5) * x + T(0.5), T(0.5) * y + T(0.5)};
}
inline Vec2 direction_to_octahedral(Vec3 d) {
    const auto [x, y] = octahedral_square<float>(d);
    return {x, y};
}
/// Inverse of the octahedral map; returns a unit vector.
inline Vec3 octahedral_to_direction(Vec2 p) {
    float x = 2 * p.x - 1, y = 2 * p.y - 1;
    const float z = 1 - std::fabs(x) - std::fabs(y);
    if (z < 0) {
        const float fold = (1 - std::fabs(y)) * sign_not_zero(x);
        y = (1 - std::fabs(x)) * sign_not_zero(y);
        x = fold;
    }
    return normalize({x, y, z});
}

/// Cosine and sine of an angle in [0, π/2], given as its distance a from π/4. The polynomials of Cephes, to
/// the last places of a double, so that directions find their texels again (in float: sampling/warp.h). Only
/// arithmetic, so that loops over them vectorise.
inline std::array<double, 2> cos_sin_from_eighth(double a) {
    const double s = a * a;
    const double sine =
        a + a * s *
                (-1.66666666666666307295e-1 +
                 s * (8.33333333332211858878e-3 +
                      s * (-1.98412698295895385996e-4 +
                           s * (2.75573136213857245213e-6 +
                                s * (-2.50507477628578072866e-8 + s * 1.58962301576546568060e-10)))));
    const double cosine =
        1 - 0.5 * s +
        s * s *
            (4.16666666666665929218e-2 +
             s * (-1.38888888888730564116e-3 +
                  s * (2.48015872888517045348e-5 +
                       s * (-2.75573141792967388112e-7 +
                            s * (2.08757008419747316778e-9 - s * 1.13585365213876817300e-11)))));
    return {M_SQRT1_2 * (cosine - sine), M_SQRT1_2 * (cosine + sine)};
}
/// Angle of (x, y) from the x axis in right angles, x and y >= 0; 0 for (0, 0). Cephes' arc tangent,
/// likewise.
inline double quadrant_share(double x, double y) {
    const double low = x < y ? x : y, high = x < y ? y : x;
    const bool far = low > 0.66 * high;
    const double q = (far ? low - high : low) / (far ? low + high : high > 0 ? high : 1), s = q * q;
    const double above = -6.485021904942025371773e1 +
                         s * (-1.228866684490136173410e2 +
                              s * (-7.500855792314704667340e1 +
                                   s * (-1.615753718733365076637e1 - s * 8.750608600031904122785e-1)));
    const double below = 1.945506571482613964425e2 +
                         s * (4.853903996359136964868e2 +
                              s * (4.328810604912902668951e2 +
                                   s * (1.650270098316988542046e2 + s * (2.485846490142306297962e1 + s))));
    const double share = (far ? 0.5 : 0) + (q + q * s * above / below) * M_2_PI;
    return x < y ? 1 - share : share;
}

/// Equal-area octahedral map (Clarberg 2008) to unit directions: equal areas of [0, 1]² are equal solid
/// angles.
inline Vec3 equal_area_to_direction(Vec2 p) {
    const double u = 2.0 * p.x - 1, v = 2.0 * p.y - 1, au = std::abs(u), av = std::abs(v);
    // Distance from the diamond |u| + |v| = 1, which is the equator; positive inside, on the upper half.
    const double signed_distance = 1 - (au + av), r = 1 - std::abs(signed_distance);
    // The position along the diamond's side is the angle, measured from its middle.
    const auto [cosine, sine] = cos_sin_from_eighth((av - au) / (r == 0 ? 1 : r) * M_PI_4);
    // 1 − r² in height: equal areas of the square are equal areas on the sphere.
    const double z = std::copysign(1 - r * r, signed_distance);
    const double s = r * std::sqrt(std::max(0.0, 2 - r * r));
    return {float(std::copysign(cosine * s, u)), float(std::copysign(sine * s, v)), float(z)};
}
/// Inverse of `equal_area_to_direction`, for unit directions.
inline Vec2 direction_to_equal_area(Vec3 d) {
    const double x = std::abs(double(d.x)), y = std::abs(double(d.y)), z = std::abs(double(d.z));
    // r = √(1 − |z|), computed from the sine to stay accurate near the poles
    const double r = std::min(1.0, std::sqrt((x * x + y * y) / (1 + z)));
    // The angle is the share of r that belongs to v.
    const double near_v = quadrant_share(x, y) * r, near_u = r - near_v;
    const double u = std::copysign(d.z < 0 ? 1 - near_v : near_u, double(d.x));
    const double v = std::copysign(d.z < 0 ? 1 - near_u : near_v, double(d.y));
    return {float(0.5 * u + 0.5), float(0.5 * v + 0.5)};
}

/// A cell of a map of size × size cells. It may lie outside the map.
struct MapCell {
    int x, y;
};
/// Folds a cell outside the map back into it, across the border as the octahedral map continues there.
inline MapCell folded(MapCell c, int size) {
    // Beyond the left border the map continues with itself, turned upside down: cell (−1, y) is (0, size − 1
    // − y).
    while (c.x < 0 || c.x >= size) c = {c.x < 0 ? -1 - c.x : 2 * size - 1 - c.x, size - 1 - c.y};
    while (c.y < 0 || c.y >= size) c = {size - 1 - c.x, c.y < 0 ? -1 - c.y : 2 * size - 1 - c.y};
    return c;
}

}  // namespace viscache

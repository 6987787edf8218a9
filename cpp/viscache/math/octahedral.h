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
    const T l = std::max(std::fabs(dx) + std::fabs(dy) + std::fabs(dz), std::numeric_limits<T>::min());
    T x = dx / l, y = dy / l;
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

/// Equal-area octahedral map (Clarberg 2008) to unit directions: equal areas of [0, 1]² are equal solid
/// angles.
inline Vec3 equal_area_to_direction(Vec2 p) {
    const double u = 2.0 * p.x - 1, v = 2.0 * p.y - 1, au = std::abs(u), av = std::abs(v);
    const double signed_distance = 1 - (au + av), r = 1 - std::abs(signed_distance);
    const double phi = (r == 0 ? 1 : (av - au) / r + 1) * M_PI / 4;
    const double z = std::copysign(1 - r * r, signed_distance);
    const double s = r * std::sqrt(std::max(0.0, 2 - r * r));
    return {float(std::copysign(std::cos(phi) * s, u)), float(std::copysign(std::sin(phi) * s, v)), float(z)};
}
/// Inverse of `equal_area_to_direction`, for unit directions.
inline Vec2 direction_to_equal_area(Vec3 d) {
    const double x = std::abs(double(d.x)), y = std::abs(double(d.y)), z = std::abs(double(d.z));
    // r = √(1 − |z|), computed from the sine to stay accurate near the poles
    const double r = std::min(1.0, std::sqrt((x * x + y * y) / (1 + z)));
    const double phi = x == 0 && y == 0 ? 0 : std::atan2(y, x) * 2 / M_PI;
    double v = phi * r, u = r - v;
    if (d.z < 0) {
        const double fold = 1 - v;
        v = 1 - u;
        u = fold;
    }
    u = std::copysign(u, double(d.x));
    v = std::copysign(v, double(d.y));
    return {float(0.5 * u + 0.5), float(0.5 * v + 0.5)};
}

/// A cell of a map of size × size cells. It may lie outside the map.
struct MapCell {
    int x, y;
};
/// Folds a cell outside the map back into it, across the border as the octahedral map continues there.
inline MapCell folded(MapCell c, int size) {
    while (c.x < 0 || c.x >= size) c = {c.x < 0 ? -1 - c.x : 2 * size - 1 - c.x, size - 1 - c.y};
    while (c.y < 0 || c.y >= size) c = {size - 1 - c.x, c.y < 0 ? -1 - c.y : 2 * size - 1 - c.y};
    return c;
}

}  // namespace viscache

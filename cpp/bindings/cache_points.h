#pragma once
// Query points of a visibility-map cache.
#include "arrays.h"
#include "viscache/visibility/query.h"
#include "viscache/vismap/map_cache.h"

namespace viscache::bindings {

/// A class, because pybind11 converts a plain vector to a list.
struct Points : std::vector<CachePoint> {};

/// One value per point, in a new array
template <class T, class Value>
py::array_t<T> column(size_t n, Value value) {
    py::array_t<T> a{py::ssize_t(n)};
    T* to = a.mutable_data();
    for (size_t i = 0; i < n; ++i) to[i] = T(value(i));
    return a;
}
template <class Value>
py::array_t<float> vectors(size_t n, Value value) {
    std::vector<Vec3> v(n);
    for (size_t i = 0; i < n; ++i) v[i] = value(i);
    return from_vec3s(v);
}

/// Throws for points that cannot be looked up. The error names the row.
inline void check_point(const CachePoint& p, size_t i) {
    const std::string row = ", row " + std::to_string(i);
    if (!is_finite(p.position) || !(max_abs(p.position) <= kMaxCoordinate))
        throw py::value_error("positions must be finite and at most 1e16 in size" + row + " is not");
    if (!(p.d_max >= 0) || !(p.d_max <= kMaxCoordinate))
        throw py::value_error("d_max must be in [0, 1e16]" + row + " has " + std::to_string(p.d_max));
    if (!(p.footprint >= 0) || !(p.footprint <= kMaxCoordinate))
        throw py::value_error("footprint must be in [0, 1e16]" + row + " has " + std::to_string(p.footprint));
    // Points without a surface have no normal either.
    if (p.usable() && !(std::fabs(length2(p.normal) - 1) < 1e-3f))
        throw py::value_error("normals must be unit vectors" + row + " has length " +
                              std::to_string(length(p.normal)));
}

}  // namespace viscache::bindings

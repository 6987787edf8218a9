#pragma once
// Conversions between NumPy arrays and C++. Errors name the argument.
#include <pybind11/pybind11.h>

#include <string>
#include <vector>

#include "real_numbers.h"
#include "viscache/math/vec.h"

namespace viscache::bindings {

namespace py = pybind11;
// Arrays of other types and layouts are copied; those that fit are used in place.
using FloatArray = RealArray<float, py::array::c_style | py::array::forcecast>;
using DoubleArray = RealArray<double, py::array::c_style | py::array::forcecast>;
using UintArray = RealArray<uint32_t, py::array::c_style | py::array::forcecast>;
using BoolArray = py::array_t<bool, py::array::c_style | py::array::forcecast>;
using WordArray = py::array_t<uint64_t, py::array::c_style | py::array::forcecast>;
using Float3 = std::array<float, 3>;

inline std::string shape_text(const py::array& a) {
    std::string s = "(";
    for (py::ssize_t i = 0; i < a.ndim(); ++i) s += (i ? ", " : "") + std::to_string(a.shape(i));
    return s + (a.ndim() == 1 ? ",)" : ")");
}

/// Throws unless the shape is (N, columns). The error names the argument and its shape.
inline void require_rows(const py::array& a, py::ssize_t columns, const char* name) {
    if (a.ndim() != 2 || a.shape(1) != columns)
        throw py::value_error(std::string(name) + " must have shape (N, " + std::to_string(columns) +
                              "), got " + shape_text(a));
}

/// Rows of an (N, 3) array, not copied. They are valid as long as the array.
// Three floats side by side, without padding
inline const Vec3* rows3(const FloatArray& a, const char* name) {
    require_rows(a, 3, name);
    return reinterpret_cast<const Vec3*>(a.data());
}

inline std::vector<Vec3> vec3s(const FloatArray& a, const char* name) {
    const Vec3* rows = rows3(a, name);
    return {rows, rows + a.shape(0)};
}

inline Vec3 vec3(const std::array<float, 3>& a) { return {a[0], a[1], a[2]}; }
inline std::array<float, 3> array3(Vec3 v) { return {v.x, v.y, v.z}; }

/// A new (N,) array with the given values.
template <class T>
py::array_t<T> array_of(const std::vector<T>& values) {
    return py::array_t<T>(py::ssize_t(values.size()), values.data());
}

/// A new (N, 3) array with the given rows.
inline py::array_t<float> from_vec3s(const std::vector<Vec3>& v) {
    py::array_t<float> a({py::ssize_t(v.size()), py::ssize_t(3)});
    if (!v.empty()) std::memcpy(a.mutable_data(), v.data(), v.size() * sizeof(Vec3));
    return a;
}

}  // namespace viscache::bindings

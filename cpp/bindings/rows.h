#pragma once
// Functions of one row, applied to every row of an array.
#include <cstring>

#include "arrays.h"

namespace viscache::bindings {

/// An array for n values: (n,) for float, (n, 2) for Vec2, (n, 3) for Vec3.
template <class Value>
py::array_t<float> rows_of(py::ssize_t n) {
    if constexpr (sizeof(Value) == sizeof(float)) return py::array_t<float>(n);
    return py::array_t<float>({n, py::ssize_t(sizeof(Value) / sizeof(float))});
}

/// f(row) for every row. `Row` is float for (N,), Vec2 for (N, 2) or Vec3 for (N, 3). The error names the
/// argument.
template <class Row, class F>
py::array_t<float> map_rows(const FloatArray& a, const char* name, F f) {
    using Value = decltype(f(Row{}));
    if constexpr (sizeof(Row) == sizeof(float)) {
        if (a.ndim() != 1)
            throw py::value_error(std::string(name) + " must have shape (N,), got " + shape_text(a));
    } else {
        require_rows(a, sizeof(Row) / sizeof(float), name);
    }
    py::array_t<float> out = rows_of<Value>(a.shape(0));
    const auto* in = reinterpret_cast<const Row*>(a.data());
    auto* to = reinterpret_cast<Value*>(out.mutable_data());
    for (py::ssize_t i = 0; i < a.shape(0); ++i) to[i] = f(in[i]);
    return out;
}

}  // namespace viscache::bindings

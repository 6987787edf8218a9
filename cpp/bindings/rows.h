#pragma once
// Functions of one row, applied to every row of an array.
#include <span>

#include "arrays.h"

namespace viscache::bindings {

/// An array for n values: (n,) for float, (n, 2) for Vec2, (n, 3) for Vec3.
template <class Value>
py::array_t<float> rows_of(py::ssize_t n) {
    // One number per row: no second axis
    if constexpr (sizeof(Value) == sizeof(float)) return py::array_t<float>(n);
    return py::array_t<float>({n, py::ssize_t(sizeof(Value) / sizeof(float))});
}

/// Values that f(rows, values) writes, one for each row. `Row` is float for (N,), Vec2 for (N, 2) or Vec3 for
/// (N, 3), and so is `Value`. The error names the argument.
template <class Row, class Value, class F>
py::array_t<float> map_all_rows(const FloatArray& a, const char* name, F f) {
    if constexpr (sizeof(Row) == sizeof(float)) {
        if (a.ndim() != 1)
            throw py::value_error(std::string(name) + " must have shape (N,), got " + shape_text(a));
    } else {
        require_rows(a, sizeof(Row) / sizeof(float), name);
    }
    py::array_t<float> out = rows_of<Value>(a.shape(0));
    f(std::span(reinterpret_cast<const Row*>(a.data()), size_t(a.shape(0))),
      std::span(reinterpret_cast<Value*>(out.mutable_data()), size_t(a.shape(0))));
    return out;
}

/// f(row) for every row.
template <class Row, class F>
py::array_t<float> map_rows(const FloatArray& a, const char* name, F f) {
    using Value = decltype(f(Row{}));
    return map_all_rows<Row, Value>(a, name, [&](std::span<const Row> rows, std::span<Value> values) {
        for (size_t i = 0; i < rows.size(); ++i) values[i] = f(rows[i]);
    });
}

}  // namespace viscache::bindings

#pragma once
// Rows of vectors in NumPy arrays of any layout.
#include "arrays.h"
#include "viscache/casters/ray_arrays.h"

namespace viscache::bindings {

/// Of any layout.
using AnyFloatArray = RealArray<float, py::array::forcecast>;

/// Rows of an (N, 3) array, read in place where the three numbers of a row lie side by side.
class RowView {
public:
    RowView(const AnyFloatArray& a, const char* name) {
        require_rows(a, 3, name);
        constexpr py::ssize_t kFloat = sizeof(float);
        // Whole floats between rows and a whole address: then pointers to float can walk the array.
        const bool in_place = a.strides(1) == kFloat && a.strides(0) % kFloat == 0 &&
                              reinterpret_cast<uintptr_t>(a.data()) % kFloat == 0;
        if (in_place) {
            rows = {a.data(), ptrdiff_t(a.strides(0) / kFloat)};
        } else {
            copy_ = Copy::ensure(a);
            rows = {copy_.data(), 3};
        }
    }
    Rows rows;

private:
    static constexpr int kAligned = py::detail::npy_api::NPY_ARRAY_ALIGNED_;
    using Copy = py::array_t<float, int(py::array::c_style) | kAligned>;
    Copy copy_;
};

}  // namespace viscache::bindings

#pragma once
// Keys of the quantized cache as rows of arrays.
#include "arrays.h"
#include "viscache/aqvc/bit_table.h"
#include "viscache/aqvc/cluster_key.h"

namespace viscache::bindings {

using KeyArray = py::array_t<int32_t, py::array::c_style | py::array::forcecast>;

/// Rows of an (N, 15) array, not copied. They are valid as long as the array.
inline const FullKey* key_rows(const KeyArray& keys) {
    require_rows(keys, 15, "keys");
    return reinterpret_cast<const FullKey*>(keys.data());
}

inline HashScheme scheme_named(const std::string& name) {
    if (name == "scheme2") return HashScheme::kScheme2;
    if (name == "scheme1") return HashScheme::kScheme1;
    if (name == "scheme1_mixed") return HashScheme::kScheme1Mixed;
    throw py::value_error("scheme must be scheme2, scheme1 or scheme1_mixed, got " + name);
}

/// How many resolutions were clamped, and why.
inline py::dict clamps_dict(const ClampCounts& clamps) {
    return py::dict(py::arg("low") = clamps.low, py::arg("high") = clamps.high, py::arg("nan") = clamps.nan);
}

}  // namespace viscache::bindings

#pragma once
// Eye points and far ends as dicts of arrays: from Python for queries, to Python for oracles written there.
#include <pybind11/numpy.h>

#include <span>

#include "viscache/visibility/oracle.h"

namespace viscache::bindings {

/// Eye points from {"positions", "normals", "origins", "density", "order", "tile"}. Errors name the array.
/// Without "origins" the origins are offset from the positions; `extent` is Scene::offset_extent.
EyeBlock eye_block_from(const pybind11::dict& arrays, float extent);
pybind11::dict eye_block_dict(const EyeBlock& eyes);

/// Far ends from {"kind", "group", "positions", "normals", "ends", "density", "t_max"}. Errors name the
/// array.
FarEnds far_ends_from(const pybind11::dict& arrays, float extent);
pybind11::dict far_ends_dict(const FarEnds& ends);

/// Connection k joins eye point index[k] with the k-th far end.
std::vector<ShadowQuery> queries_from(const FarEnds& ends, std::span<const uint32_t> index);

/// Bit rows as an array of bool, (rows, columns).
pybind11::array_t<bool> unpacked(const BitMatrix& bits);
/// Bit rows as an array of uint64, (rows, words).
pybind11::array_t<uint64_t> packed(const BitMatrix& bits);

}  // namespace viscache::bindings

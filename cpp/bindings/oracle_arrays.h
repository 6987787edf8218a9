#pragma once
// Eye points and far ends as arrays: from Python for questions, to Python for oracles written there.
#include <pybind11/numpy.h>

#include <span>

#include "viscache/visibility/oracle.h"

namespace viscache::bindings {

/// {"positions", "normals", "origins", "density", "order", "tile"} of eye points; checked, errors name the
/// array. Origins that are not given are spawned off the positions; `extent` is Scene::offset_extent.
EyeBlock eye_block_from(const pybind11::dict& arrays, float extent);
pybind11::dict eye_block_dict(const EyeBlock& eyes);

/// {"kind", "group", "positions", "normals", "ends", "density", "t_max"} of far ends; checked.
FarEnds far_ends_from(const pybind11::dict& arrays, float extent);
pybind11::dict far_ends_dict(const FarEnds& ends);

/// Connections: connection k joins eye point index[k] with the k-th far end.
std::vector<ShadowQuery> queries_from(const FarEnds& ends, std::span<const uint32_t> index);

/// (rows, columns) bool of rows of bits.
pybind11::array_t<bool> unpacked(const BitMatrix& bits);
/// (rows, words) uint64.
pybind11::array_t<uint64_t> packed(const BitMatrix& bits);

}  // namespace viscache::bindings

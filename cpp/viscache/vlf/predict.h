#pragma once
// How large a field will be, before it is built.
#include <cstdint>
#include <span>
#include <string>

#include "viscache/math/parallel.h"
#include "viscache/vlf/visibility_field.h"

namespace viscache {

/// Tiles that triangles in the unit ball touch, on average over directions and places: with tiles c wide, a
/// triangle of area A and perimeter P touches A/(2c²) + P/(2c) + 1 of them (a convex shape's projection has
/// half its area, and reaches P/4 along either axis, on average).
double expected_references(std::span<const FlatTriangle> triangles, int n_tiles);

/// Bytes of a field, and those that a thread takes besides while it builds.
struct PredictedBytes {
    uint64_t field = 0, builder = 0;
    /// With one thread.
    uint64_t peak() const { return field + builder; }
};

/// Bytes of a whole field: those of the triangles, and of the subfields of a few directions, spread over all
/// of them, for the rest. Builds those one at a time.
PredictedBytes predicted_peak(const FieldTriangles& triangles, const FieldSettings& settings, int threads,
                              const Control& control);

/// The field's alone.
uint64_t predicted_bytes(const FieldTriangles& triangles, const FieldSettings& settings, int threads,
                         const Control& control);

/// Throws OverBudget for a field that is predicted to be larger, while one thread builds it, than
/// settings.max_bytes; its text names the bytes, the budget and the largest n_tiles, bsp_depth and
/// n_directions that fit, each with the others kept. Returns how many of the threads may build at a time.
int check_budget(const FieldTriangles& triangles, const FieldSettings& settings, int threads,
                 const Control& control);

}  // namespace viscache

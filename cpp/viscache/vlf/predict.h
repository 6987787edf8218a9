#pragma once
// Predicts the size of a field before it is built.
#include <cstdint>
#include <span>

#include "viscache/math/parallel.h"
#include "viscache/vlf/visibility_field.h"

namespace viscache {

/// Expected number of tiles that the triangles in the unit ball touch, averaged over directions and
/// positions. With tiles of width c, a triangle of area A and perimeter P touches A/(2c²) + P/(2c) + 1
/// tiles: on average, the projection of a convex shape has half its area and extends P/4 along either axis.
double expected_references(std::span<const FlatTriangle> triangles, int n_tiles);

/// Bytes of a field, and the working memory of one builder thread.
struct PredictedBytes {
    uint64_t field = 0, builder = 0;
    /// With one builder thread.
    uint64_t peak() const { return field + builder; }
};

/// Predicts the bytes of a whole field from the triangles and from the subfields of a few evenly spread
/// directions. These subfields are built here, one at a time.
PredictedBytes predicted_peak(const FieldTriangles& triangles, const FieldSettings& settings, int threads,
                              const Control& control);

/// The bytes of the field alone.
uint64_t predicted_bytes(const FieldTriangles& triangles, const FieldSettings& settings, int threads,
                         const Control& control);

/// Throws OverBudget if the field and the working memory of one builder thread are predicted to exceed
/// settings.max_bytes. The message gives the bytes, the budget, and the largest n_tiles, bsp_depth and
/// n_directions that fit, each with the others unchanged. Returns the number of builder threads that fit
/// into the budget, at most `threads`.
int check_budget(const FieldTriangles& triangles, const FieldSettings& settings, int threads,
                 const Control& control);

}  // namespace viscache

#pragma once
// Directions, tiles and depth chosen to fit a budget.
#include "viscache/vlf/predict.h"

namespace viscache {

/// Steps of a ray through a field by rule of thumb, for comparing settings.
struct FieldCost {
    double tiles = 0, tests = 0;
    /// In tests: a tile costs about two, most of it waiting for memory.
    double total() const { return 2 * tiles + tests; }
};

/// [1 + (4/π) s sin δ n/2] tiles, with s = 4/3 the mean chord of the ball and δ the mean angle to the nearest
/// of l axes; and as tests what these tiles list on average, in the leaves that the ray crosses.
FieldCost expected_cost(const FieldTriangles& triangles, const FieldSettings& settings);

/// CPU seconds to build a whole field, by rule of thumb: 75 ns a reference and 27 ns a tile (within a quarter
/// on one machine, over 16 settings of four scenes).
double expected_build_s(const FieldTriangles& triangles, const FieldSettings& settings);

/// The settings with what they leave open chosen: the cheapest by `expected_cost` that fits max_bytes by
/// prediction and max_build_s by rule of thumb; the smallest where none does.
FieldSettings chosen_settings(const FieldTriangles& triangles, const FieldSettings& settings, int threads,
                              const Control& control);

}  // namespace viscache

#pragma once
// Chooses the number of directions, the number of tiles and the depth to fit a budget.
#include "viscache/vlf/predict.h"

namespace viscache {

/// Estimated number of steps of a ray through a field, for comparing settings.
struct FieldCost {
    double tiles = 0, tests = 0;
    /// In units of tests. A tile costs about two tests, most of it waiting for memory.
    double total() const { return 2 * tiles + tests; }
};

/// Tiles: 1 + (4/π) s sin δ n/2, where s = 4/3 is the mean chord of the ball and δ the mean angle to the
/// nearest of l axes. Tests: the triangles that these tiles list on average, in the leaves that the ray
/// crosses.
FieldCost expected_cost(const FieldTriangles& triangles, const FieldSettings& settings);

/// Estimated CPU seconds to build a whole field: 75 ns per reference and 27 ns per tile (within a quarter on
/// one machine, over 16 settings of four scenes).
double expected_build_s(const FieldTriangles& triangles, const FieldSettings& settings);

/// Fills in the settings that are left open. Chooses the cheapest by `expected_cost` whose predicted size
/// fits max_bytes and whose estimated build time fits max_build_s. If none fits, chooses the smallest.
FieldSettings chosen_settings(const FieldTriangles& triangles, const FieldSettings& settings, int threads,
                              const Control& control);

}  // namespace viscache

#pragma once
// Aligned rays by lookup in a visibility field, and their cost.
#include "viscache/vlf/aligned_batch.h"
#include "viscache/vlf/visibility_field.h"

namespace viscache {

/// The bits of AlignedBatch::rows, computed by any-hit lookups in a field whose directions are the axes of
/// the input. Each ray visits the leaves of one tile. The axes are processed one after the other, so that
/// the lists of a subfield stay in the caches. Throws std::invalid_argument for a field with other
/// directions, and for points farther from the scene than 1e9 times its size.
void field_rows(const VisibilityField& field, const AlignedInput& input, std::span<Word> rows, int threads,
                Control& control);

/// Predicted cost of aligned rays in a field that is not built yet.
struct FieldPrediction {
    double tests = 0;    ///< triangle tests per ray
    double ray_ns = 0;   ///< per ray on one core
    double build_s = 0;  ///< CPU seconds
    double bytes = 0;    ///< lower bound
};

/// Fixed cost of a ray and cost of a triangle test, in nanoseconds. Fitted to 12 measurements of 6 scenes
/// with 64² and 128² tiles (a shared Zen 4), within a factor of 1.6.
constexpr double kFieldRayNs = 160, kFieldTestNs = 36;

/// Prediction from the size of the triangles and the settings, which may leave only the depth open. A ray
/// visits one tile. That tile lists R/(0.785 n²) of the R references of a direction, divided by depth, and
/// the ray crosses half of it.
FieldPrediction predict_field_rows(const FieldTriangles& triangles, const FieldSettings& settings);

}  // namespace viscache

#pragma once
// Aligned rays by look-up in a visibility field, and what they cost.
#include "viscache/vlf/aligned_batch.h"
#include "viscache/vlf/visibility_field.h"

namespace viscache {

/// The bits of AlignedBatch::rows by any hits in a field whose directions are the input's axes: each ray
/// meets the leaves of one tile. Axis by axis, so that a subfield's lists stay in the caches. Throws
/// std::invalid_argument for a field of other directions, and for points farther than 1e9 times the scene's
/// size from it.
void field_rows(const VisibilityField& field, const AlignedInput& input, std::span<Word> rows, int threads,
                Control& control);

/// What aligned rays take in a field that is not built yet.
struct FieldPrediction {
    double tests = 0;    ///< of a triangle, per ray
    double ray_ns = 0;   ///< on one core
    double build_s = 0;  ///< CPU seconds
    double bytes = 0;    ///< at least
};

/// Nanoseconds of a ray, whatever its tile lists, and of a test of a triangle. Fitted to 12 measurements of 6
/// scenes with 64² and 128² tiles (a shared Zen 4), within a factor of 1.6.
constexpr double kFieldRayNs = 160, kFieldTestNs = 36;

/// From the settings, which must leave at most the depth to choose, and the triangles' size: a ray meets one
/// tile, that lists R/(0.785 n²) of the R references of a direction, parted along its depth, and crosses half
/// of it.
FieldPrediction predict_field_rows(const FieldTriangles& triangles, const FieldSettings& settings);

}  // namespace viscache

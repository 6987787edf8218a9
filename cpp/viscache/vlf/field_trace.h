#pragma once
// Nearest-hit and any-hit queries of one ray in the lists of one direction.
#include "viscache/vlf/field_triangles.h"
#include "viscache/vlf/field_walk.h"
#include "viscache/vlf/visibility_field.h"

namespace viscache {

/// The nearest hit, with t in the caller's units.
template <class Layer>
NearestHit nearest_hit(const FieldTriangles& triangles, std::span<const Layer* const> layers,
                       const Frame3& frame, const TileFit& fit, const FieldSettings& settings, const Ray& ray,
                       FieldSteps* steps) {
    // Three forms of one ray: in the unit ball, in double, for the walk; near the scene, in float, for the
    // triangles; and rotated to the direction, clipped to the cube, for tiles and depths.
    const FieldRay in_ball(ray, triangles.space());
    const LocalRay local = triangles.to_local(ray, in_ball);
    const CanonicalRay canonical(in_ball, frame, ray.t_min, ray.t_max, fit);
    NearestHit best = triangles.with_kernel(local.ray, [&](const auto& kernel) {
        NearestHit nearest{local.ray.t_max};
        // The walk works with t of the caller, the kernels with local t.
        walk_field(layers, canonical, settings.n_tiles, settings.walk, ray.t_max, steps,
                   [&](std::span<const uint32_t> ids, double) {
                       triangles.nearest(kernel, ids, nearest);
                       return nearest.id == kNoHit ? double(ray.t_max) : nearest.t + local.shift;
                   });
        return nearest;
    });
    // Most rays are not moved, and their t keeps its bits.
    if (local.shift != 0) best.t = float(best.t + local.shift);
    return best;
}

template <class Layer>
bool any_hit(const FieldTriangles& triangles, std::span<const Layer* const> layers, const Frame3& frame,
             const TileFit& fit, const FieldSettings& settings, const Ray& ray, FieldSteps* steps) {
    const FieldRay in_ball(ray, triangles.space());
    const LocalRay local = triangles.to_local(ray, in_ball);
    const CanonicalRay canonical(in_ball, frame, ray.t_min, ray.t_max, fit);
    return triangles.with_kernel(local.ray, [&](const auto& kernel) {
        bool found = false;
        walk_field(layers, canonical, settings.n_tiles, settings.walk, ray.t_max, steps,
                   [&](std::span<const uint32_t> ids, double limit) {
                       found = triangles.any(kernel, ids, local.ray.t_max);
                       // Below every t: the walk ends at once.
                       return found ? -double(kInfinity) : limit;
                   });
        return found;
    });
}

}  // namespace viscache

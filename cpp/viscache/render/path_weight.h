#pragma once
// Multiple importance sampling over all ways to make one path (Veach 1997, Sec. 10.2): the balance heuristic.
#include <span>

#include "viscache/render/path_vertex.h"

namespace viscache {

/// Densities that change where an eye and a light sub-path are joined: those with which the other side would
/// have made the last vertex of each, and the one before.
struct JoinDensities {
    double eye_last = 0, eye_before = 0, light_last = 0, light_before = 0;
};

/// Which strategies exist.
struct StrategyRules {
    bool to_camera = true;  ///< light paths are connected to the camera
    bool hittable = false;  ///< eye paths can find this path's light by chance
};

/// Weight of the strategy that made a path from the eye's vertices z₀ (the camera) … z_{t−1} and the light's
/// y₀ … y_{s−1}: its density over the sum of all strategies' densities. With s = 0 the last vertex of the eye
/// lies on the light.
double path_weight(std::span<const PathVertex> eye, std::span<const PathVertex> light,
                   const JoinDensities& join, StrategyRules rules);

}  // namespace viscache

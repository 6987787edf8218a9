#pragma once
// Multiple importance sampling over all strategies for one path (Veach 1997, Sec. 10.2): the balance
// heuristic.
#include <span>

#include "viscache/render/path_vertex.h"

namespace viscache {

/// Densities that a connection changes: those of the last two vertices of each sub-path, had the other side
/// made them.
struct JoinDensities {
    double eye_last = 0, eye_before = 0, light_last = 0, light_before = 0;
};

/// The strategies in use.
struct StrategyRules {
    bool to_camera = true;  ///< light paths are connected to the camera
    bool hittable = false;  ///< eye paths can find this path's light by chance
};

/// Weight of the strategy that made a path from the eye vertices z₀ (the camera) … z_{t−1} and the light
/// vertices y₀ … y_{s−1}: its density over the sum of the densities of all strategies. With s = 0, the last
/// eye vertex lies on the light.
double path_weight(std::span<const PathVertex> eye, std::span<const PathVertex> light,
                   const JoinDensities& join, StrategyRules rules);

}  // namespace viscache

#include "viscache/render/path_weight.h"

namespace viscache {

double path_weight(std::span<const PathVertex> eye, std::span<const PathVertex> light,
                   const JoinDensities& join, StrategyRules rules) {
    const size_t t = eye.size(), s = light.size();
    // Whether a connection could touch a vertex of this path. At the last one, the path scatters where it
    // may pass a glossy sheet elsewhere
    const auto rough = [](std::span<const PathVertex> path, size_t i) {
        return path[i].connects && (i + 1 == path.size() || !path[i].passed);
    };
    // All densities relative to the strategy that made the path: ratios stay in range where
    // products of ten densities would not
    double others = 0;
    // Strategies with fewer eye vertices: the light makes the last ones
    double ratio = 1;
    // Moving vertex i from the eye's sub-path to the light's replaces its forward density by its
    // reverse one
    for (size_t i = t - 1; i >= 1; --i) {
        const double reverse = i == t - 1 ? join.eye_last : i == t - 2 ? join.eye_before : eye[i].reverse;
        ratio *= reverse / eye[i].forward;
        // A path of one edge from the light to the camera is left to eye paths
        const bool allowed = i > 1 || (rules.to_camera && s + t > 2);
        // Strategies whose connection would touch a mirror cannot make this path, but ratios go on
        // through it
        if (allowed && rough(eye, i) && rough(eye, i - 1)) others += ratio;
    }
    // Strategies with more eye vertices
    ratio = 1;
    for (size_t i = s; i-- > 0;) {
        const double reverse = i == s - 1   ? join.light_last
                               : i + 2 == s ? join.light_before
                                            : light[i].reverse;
        ratio *= reverse / light[i].forward;
        // i = 0: the eye path finds the light itself, without a connection
        const bool allowed = i == 0 ? rules.hittable : rough(light, i - 1);
        if (allowed && rough(light, i)) others += ratio;
    }
    // An eye path may hit a light that is not hittable. The hit counts only if no other strategy finds this
    // path
    if (s == 0 && !rules.hittable) return others > 0 ? 0 : 1;
    return 1 / (1 + others);
}

}  // namespace viscache

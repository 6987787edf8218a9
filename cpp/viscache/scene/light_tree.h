#pragma once
// A tree over area lights, for choosing among many of them by their estimated contribution (Conty Estevez and
// Kulla 2018, "Importance sampling of many lights with adaptive tree splitting").
#include <cstdint>
#include <optional>
#include <vector>

#include "viscache/scene/light_bounds.h"

namespace viscache {

/// A light chosen with probability pmf.
struct LightPick {
    size_t light;
    double pmf;
};

/// A binary tree with one area light per leaf.
class LightTree {
public:
    struct Node {
        LightGroupBounds bounds;  ///< unset in leaves, which are estimated by their light
        Bounds box;
        uint32_t parent = 0;
        /// Inner nodes: index of the second child; the first follows its parent. Leaves: the light.
        uint32_t other = 0;
        bool leaf = false;
    };

    /// `lights` must outlive the tree and must not be empty.
    explicit LightTree(const AreaLights& lights);

    /// Goes down from the root with one random number u in [0, 1). Empty where the way ends at lights that
    /// send nothing to the receiver.
    std::optional<LightPick> sample(const Receiver& r, double u) const;
    /// Probability that `sample` returns this light.
    double pmf(const Receiver& r, size_t light) const;
    /// nodes()[0] is the root.
    const std::vector<Node>& nodes() const { return nodes_; }

private:
    double node_importance(uint32_t node, const Receiver& r) const;

    const AreaLights& lights_;
    std::vector<Node> nodes_;
    std::vector<uint32_t> leaf_of_;  ///< node of each light
};

/// Estimated irradiance from one light, counted over triangles, then spheres.
inline double estimated_light(const AreaLights& lights, size_t light, const Receiver& r) {
    const size_t triangles = lights.triangles.size();
    return light < triangles ? estimated_light(lights.triangles[light], r)
                             : estimated_light(lights.spheres[light - triangles], r);
}

}  // namespace viscache

#pragma once
// A tree over area lights, for choosing among many of them by their estimated contribution (Conty Estevez and
// Kulla 2018, "Importance sampling of many lights with adaptive tree splitting").
#include <cstdint>
#include <span>
#include <vector>

#include "viscache/scene/light_bounds.h"

namespace viscache {

/// A light chosen with probability pmf; 0: none.
struct LightPick {
    size_t light = 0;
    double pmf = 0;
};

/// A random number in [0, 1), and the sample that it chooses a light for.
struct LightDraw {
    double u;
    uint32_t sample;
};

/// A binary tree with one area light per leaf.
class LightTree {
public:
    /// Nodes that wait while one is visited, at most: no tree is deeper (40 levels, then halves).
    static constexpr size_t kMostWaiting = 128;

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

    /// Chooses picks[draw.sample] for every draw, going down from the root with one random number each. None
    /// where the way ends at lights that send nothing to the receiver. `draws` are sorted by u, and changed:
    /// the ways of all of them share their nodes.
    void sample(const Receiver& r, std::span<LightDraw> draws, std::span<LightPick> picks) const;
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

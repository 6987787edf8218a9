#pragma once
// A light group with weights, for oracles that skip connections and weight the others.
#include <optional>

#include "viscache/render/light_pick.h"

namespace viscache {

/// The light group with the weights of one eye point after another: values times weights. If the row of
/// weights stays the same, as within a voxel, it is multiplied only once.
class WeightedLights {
public:
    explicit WeightedLights(const SharedLights& lights) : lights_(lights) {}

    /// `weights`: one per column; empty: the group itself.
    const SharedLights& with(std::span<const float> weights) {
        if (weights.empty()) return lights_;
        // Copied once per group, and only for oracles with weights
        if (!scaled_) scaled_ = lights_;
        // Rows of weights lie in the oracle and do not change within a block, so their address
        // names them
        if (weights.data() == last_) return *scaled_;
        last_ = weights.data();
        for (size_t k = 0; k < lights_.ends.count; ++k) {
            scaled_->r[k] = lights_.r[k] * weights[k];
            scaled_->g[k] = lights_.g[k] * weights[k];
            scaled_->b[k] = lights_.b[k] * weights[k];
        }
        return *scaled_;
    }

    /// The same where the eye point picked lights; the other columns may hold any finite values.
    const SharedLights& with(std::span<const PickedLight> picked, std::span<const float> weights) {
        if (picked.empty()) return with(weights);
        if (!scaled_) scaled_ = lights_;
        // Columns of earlier picks keep old weights; none of their bits is set
        last_ = nullptr;
        for (const PickedLight& p : picked) {
            const float weight = weights.empty() ? p.weight : p.weight * weights[p.column];
            scaled_->r[p.column] = lights_.r[p.column] * weight;
            scaled_->g[p.column] = lights_.g[p.column] * weight;
            scaled_->b[p.column] = lights_.b[p.column] * weight;
        }
        return *scaled_;
    }

private:
    const SharedLights& lights_;
    std::optional<SharedLights> scaled_;
    const float* last_ = nullptr;
};

}  // namespace viscache

#pragma once
// A light group whose columns count for more than one, as an oracle says that leaves connections out.
#include <optional>

#include "viscache/render/shared_lights.h"

namespace viscache {

/// The group as seen from one eye point after another: values times weights. A row of weights that stays the
/// same, as it does within a voxel, is multiplied once.
class WeightedLights {
public:
    explicit WeightedLights(const SharedLights& lights) : lights_(lights) {}

    /// `weights`: one per column, or empty: the group itself.
    const SharedLights& with(std::span<const float> weights) {
        if (weights.empty()) return lights_;
        if (!scaled_) scaled_ = lights_;
        if (weights.data() == last_) return *scaled_;
        last_ = weights.data();
        for (size_t k = 0; k < lights_.ends.count; ++k) {
            scaled_->r[k] = lights_.r[k] * weights[k];
            scaled_->g[k] = lights_.g[k] * weights[k];
            scaled_->b[k] = lights_.b[k] * weights[k];
        }
        return *scaled_;
    }

private:
    const SharedLights& lights_;
    std::optional<SharedLights> scaled_;
    const float* last_ = nullptr;
};

}  // namespace viscache

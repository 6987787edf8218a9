#pragma once
// Chooses one of the area lights for a sample by the contribution to the eye point.
#include <array>
#include <span>

#include "viscache/render/settings.h"
#include "viscache/scene/light_tree.h"
#include "viscache/scene/scene.h"

namespace viscache {

/// How lights are chosen: one by one where they are few, otherwise by the light tree.
enum class ChoiceWay { kEach, kTree };

/// At most this many lights are estimated one by one.
constexpr size_t kMostLightsEach = 256;

/// The way of choice for a scene with area lights, and `n_area` samples per eye point.
ChoiceWay choice_way(const AreaLights& lights, int n_area);

/// The choice at one eye point.
class LightsAt {
public:
    /// `scene` must have area lights, at most kMostLightsEach for kEach.
    LightsAt(const Scene& scene, ChoiceWay way, const Receiver& receiver);

    /// Largest number of choices at once.
    static constexpr size_t kMostPicks = 64;
    /// Chooses a light by each u in [0, 1). None only where no light can contribute.
    void pick(std::span<const double> u, std::span<LightPick> picks) const;
    /// Probability that `pick` returns this light. Positive for every light that can contribute.
    double pmf(size_t light) const;
    const Vec3& position() const { return receiver_.position; }
    const AreaLights& lights() const { return lights_; }
    /// Samples need random numbers with more than 24 bits.
    bool is_fine() const { return way_ == ChoiceWay::kTree; }

private:
    LightPick pick_one(double u) const;

    const AreaLights& lights_;
    const ChoiceWay way_;
    const Receiver receiver_;
    const LightTree* tree_ = nullptr;
    std::array<double, kMostLightsEach> sums_;  ///< running sums of the estimates, for kEach
};

}  // namespace viscache

#include "viscache/render/light_choice.h"

#include <algorithm>

namespace viscache {

namespace {
/// Measured: one way down the tree costs as much as the estimates of 12 to 25 lights. Estimates of single
/// lights are more exact, and all samples of an eye point share them.
constexpr size_t kLightsPerSample = 16;
}  // namespace

ChoiceWay choice_way(const AreaLights& lights, int n_area) {
    const size_t few = std::min(kMostLightsEach, kLightsPerSample * size_t(std::max(n_area, 0)));
    return lights.size() <= few ? ChoiceWay::kEach : ChoiceWay::kTree;
}

LightsAt::LightsAt(const Scene& scene, ChoiceWay way, const Receiver& receiver)
    : lights_(scene.area_lights()), way_(way), receiver_(receiver) {
    if (way == ChoiceWay::kTree) {
        tree_ = &scene.light_tree();
        return;
    }
    // Running sums in double: of 256 lights whose powers differ by many orders, none loses its
    // share
    double sum = 0;
    for (size_t i = 0; i < lights_.size(); ++i) {
        sum += estimated_light(lights_, i, receiver_);
        sums_[i] = sum;
    }
}

void LightsAt::pick(std::span<const double> u, std::span<LightPick> picks) const {
    if (way_ != ChoiceWay::kTree) {
        for (size_t i = 0; i < u.size(); ++i) picks[i] = pick_one(u[i]);
        return;
    }
    std::array<LightDraw, kMostPicks> draws;
    for (size_t i = 0; i < u.size(); ++i) draws[i] = {u[i], uint32_t(i)};
    const auto end = draws.begin() + ptrdiff_t(u.size());
    // Sorted numbers fall into runs at every node, so the tree is walked once for all
    std::sort(draws.begin(), end, [](const LightDraw& a, const LightDraw& b) { return a.u < b.u; });
    tree_->sample(receiver_, {draws.data(), u.size()}, picks);
}

LightPick LightsAt::pick_one(double u) const {
    const auto end = sums_.begin() + ptrdiff_t(lights_.size());
    const double total = end[-1];
    if (!(total > 0)) return {};
    auto at = std::upper_bound(sums_.begin(), end, u * total);
    // u·total was rounded up to the total
    if (at == end) at = std::lower_bound(sums_.begin(), end, total);
    const size_t light = size_t(at - sums_.begin());
    return {light, pmf(light)};
}

double LightsAt::pmf(size_t light) const {
    if (way_ == ChoiceWay::kTree) return tree_->pmf(receiver_, light);
    const double total = sums_[lights_.size() - 1];
    if (!(total > 0)) return 0;
    // From the very sums that `pick_one` searches: choice and density agree to the last bit
    return (sums_[light] - (light ? sums_[light - 1] : 0)) / total;
}

}  // namespace viscache

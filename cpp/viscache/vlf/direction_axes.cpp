#include "viscache/vlf/direction_axes.h"

#include <algorithm>

namespace viscache {

namespace {

/// A number per direction. Opposite directions have opposite numbers; other directions rarely share one.
double key(Vec3 d) {
    // Weights 1, √2 and √3: no small whole numbers make such a sum vanish, so directions of a regular grid
    // have different keys.
    return double(d.x) + 1.4142135623730951 * double(d.y) + 1.7320508075688772 * double(d.z);
}
// Each component of a sum of opposite directions may be off by kOppositeSlack, and the weights add up to
// 4.15.
constexpr double kKeySlack = 4.2 * double(kOppositeSlack);

bool opposite(Vec3 a, Vec3 b) {
    const Vec3 sum = a + b;
    return std::max({std::fabs(sum.x), std::fabs(sum.y), std::fabs(sum.z)}) <= kOppositeSlack;
}

}  // namespace

std::vector<SharedAxis> axes_of(std::span<const Vec3> directions) {
    std::vector<std::pair<double, uint32_t>> by_key;
    std::vector<Vec3> unit;
    for (uint32_t i = 0; i < directions.size(); ++i) {
        unit.push_back(normalize(directions[i]));
        by_key.emplace_back(key(unit[i]), i);
    }
    std::sort(by_key.begin(), by_key.end());
    std::vector<SharedAxis> axes;
    std::vector<bool> taken(directions.size());
    for (uint32_t i = 0; i < directions.size(); ++i) {
        // It was found as the opposite of an earlier direction.
        if (taken[i]) continue;
        SharedAxis axis{frame_around(unit[i]), length(directions[i]), i};
        // Find the first opposite direction without a partner
        // Only directions with nearly the opposite key are compared, so that n directions need n log n steps.
        const double sought = -key(unit[i]);
        for (auto at = std::lower_bound(by_key.begin(), by_key.end(), std::pair(sought - kKeySlack, 0u));
             at != by_key.end() && at->first <= sought + kKeySlack; ++at)
            // Always the lowest index, so that the axes depend on the order of the directions and on nothing
            // else.
            if (const uint32_t j = at->second; j > i && !taken[j] && opposite(unit[i], unit[j]))
                axis.against = std::min(axis.against, j);
        if (axis.against != SharedAxis::kNone) taken[axis.against] = true;
        axes.push_back(axis);
    }
    return axes;
}

}  // namespace viscache

#include "viscache/render/shared_sky.h"

#include <algorithm>

#include "viscache/sampling/low_discrepancy.h"
#include "viscache/sampling/rng.h"
#include "viscache/visibility/direction_bins.h"

namespace viscache {

SharedLights shared_sky(const EnvironmentMap& environment, int n, uint64_t seed) {
    constexpr uint64_t kAllPixels = ~uint64_t{0};
    Rng rng(seed, Purpose::kEnvironmentLight, kAllPixels, 0);
    const uint32_t scramble_x = rng.next_u32(), scramble_y = rng.next_u32();
    std::vector<Vec2> points;
    for (int i = 0; i < n; ++i) points.push_back(sobol02(uint32_t(i), scramble_x, scramble_y));
    std::vector<EnvironmentMap::Sample> samples(points.size());
    environment.sample(points, samples);
    std::stable_sort(samples.begin(), samples.end(), [](const auto& a, const auto& b) {
        return direction_bin<16>(a.wi) < direction_bin<16>(b.wi);
    });
    SharedLights sky;
    for (const auto& s : samples) {
        const float density = float(n) * s.pdf;
        if (s.pdf > 0 && max_component(s.radiance) > 0)
            sky.add(s.wi, {}, s.wi, s.radiance * (1 / density), density);
    }
    return sky;
}

}  // namespace viscache

#include "viscache/render/shared_sky.h"

#include <algorithm>

#include "viscache/sampling/low_discrepancy.h"
#include "viscache/sampling/rng.h"
#include "viscache/visibility/direction_bins.h"

namespace viscache {

SharedLights shared_sky(const EnvironmentMap& environment, int n, int sets, uint64_t seed) {
    constexpr uint64_t kAllPixels = ~uint64_t{0};
    Rng rng(seed, Purpose::kEnvironmentLight, kAllPixels, 0);
    const uint32_t scramble_x = rng.next_u32(), scramble_y = rng.next_u32();
    std::vector<Vec2> points;
    for (int i = 0; i < n; ++i) points.push_back(sobol02(uint32_t(i), scramble_x, scramble_y));
    std::vector<EnvironmentMap::Sample> samples(points.size());
    environment.sample(points, samples);
    SharedLights sky;
    for (size_t set = 0; set < size_t(sets); ++set) {
        // Runs of the sequence are as evenly spread as its beginning
        const size_t first = size_t(n) * set / size_t(sets), last = size_t(n) * (set + 1) / size_t(sets);
        const std::span run = std::span(samples).subspan(first, last - first);
        std::stable_sort(run.begin(), run.end(), [](const auto& a, const auto& b) {
            return direction_bin<16>(a.wi) < direction_bin<16>(b.wi);
        });
        for (const auto& s : run)
            if (s.pdf > 0 && max_component(s.radiance) > 0)
                sky.add(s.wi, {}, s.wi, s.radiance * (1 / (float(run.size()) * s.pdf)), float(n) * s.pdf);
        if (sets > 1) sky.ends.set_end.push_back(uint32_t(sky.ends.count));
    }
    return sky;
}

}  // namespace viscache

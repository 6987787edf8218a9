#include "viscache/render/shared_sky.h"

#include <algorithm>

#include "viscache/sampling/low_discrepancy.h"
#include "viscache/sampling/rng.h"
#include "viscache/visibility/direction_bins.h"

namespace viscache {

SharedLights shared_sky(const EnvironmentMap& environment, const IntegratorSettings& settings,
                        uint64_t seed) {
    const int n = settings.n_environment, sets = settings.interleave;
    // No pixel has this number, so no pixel's own samples share these random numbers
    constexpr uint64_t kAllPixels = ~uint64_t{0};
    Rng rng(seed, Purpose::kEnvironmentLight, kAllPixels, 0);
    const uint32_t scramble_x = rng.next_u32(), scramble_y = rng.next_u32();
    std::vector<Vec2> points;
    for (int i = 0; i < n; ++i) points.push_back(sobol02(uint32_t(i), scramble_x, scramble_y));
    std::vector<EnvironmentMap::Sample> samples(points.size());
    // In one call: the map samples points in batches
    environment.sample(points, samples);
    SharedLights sky;
    for (size_t set = 0; set < size_t(sets); ++set) {
        // Runs of the sequence are as evenly spread as its beginning
        const size_t size = size_t(set_size(n, sets, set));
        const std::span run = std::span(samples).subspan(size_t(n) * set / size_t(sets), size);
        // The samples of lobes that go with this set, for the weights of its directions
        const float lobes = float(set_size(settings.n_brdf, sets, set));
        // Neighbouring columns then have rays that meet the same geometry. Stable, so that equal
        // bins keep one order everywhere
        std::stable_sort(run.begin(), run.end(), [](const auto& a, const auto& b) {
            return direction_bin<16>(a.wi) < direction_bin<16>(b.wi);
        });
        for (const auto& s : run) {
            // Black directions bring nothing and would cost a column
            if (!(s.pdf > 0 && max_component(s.radiance) > 0)) continue;
            const float density = float(size) * s.pdf;
            // The cache gets the density of all n directions: cells are shared by all sets
            sky.add(s.wi, {}, s.wi, s.radiance * (1 / density), float(n) * s.pdf);
            if (settings.n_brdf > 0) sky.lobe_ratio.push_back(lobes / density);
        }
        // Ends are kept after black directions were left out, so sets may differ in size
        if (sets > 1) sky.ends.set_end.push_back(uint32_t(sky.ends.count));
    }
    return sky;
}

}  // namespace viscache

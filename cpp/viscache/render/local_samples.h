#pragma once
// Samples of one eye point: area lights, environment, ambient occlusion.
#include <vector>

#include "viscache/render/eye_paths.h"
#include "viscache/render/settings.h"
#include "viscache/visibility/local_samples.h"

namespace viscache {

/// Samples and their unoccluded contributions.
struct WeightedSamples {
    LocalSamples at;
    std::vector<Rgb>
        contribution;  ///< throughput · f · cos · L / (pdf · samples); RGB = fraction for ambient
    /// Starts a new list for a light group and a kind of far end.
    void begin(Semantic semantic, LightGroup group) {
        at.clear();
        contribution.clear();
        at.semantic = semantic;
        at.group = int(group);
    }
    /// Adds the sample if it contributes. Non-finite contributions are dropped and counted.
    bool add(Vec3 to, Rgb value, float density, float light_density, Counters& counters);
    /// Adds the contributions, as means of channels, to the pixels of their eye points.
    void add_to(std::span<const uint32_t> pixel_of, std::span<float> pixels) const {
        for_each_sample(at, [&](uint32_t eye, size_t i) {
            const Rgb c = contribution[i];
            pixels[pixel_of[eye]] += (c.x + c.y + c.z) / 3;
        });
    }
};

/// A query of one eye point along a direction.
ShadowQuery query_towards(uint32_t eye, Vec3 direction, LightGroup group, float density,
                          float t_max = kInfinity);

/// Largest number of samples of area lights per eye point.
int most_area_samples(const Scene& scene, const IntegratorSettings& settings);

/// Adds the samples of one eye point of a frame and closes its row. An eye point that reflects nothing gets
/// no row.
using AddSamples = void(const EyePathTracer& frame, const EyeTile& eyes, uint32_t eye, WeightedSamples& out,
                        Counters& counters);
AddSamples add_area_samples, add_environment_samples, add_ambient_samples;
/// Samples of a sharp lobe, beside the set of shared directions of the eye point (`shared_sky`).
AddSamples add_lobe_samples;
/// Largest number of samples of the lobe of one eye point, beside shared directions of the sky.
inline int most_lobe_samples(const IntegratorSettings& s) {
    return (s.n_brdf + s.interleave - 1) / s.interleave;
}

}  // namespace viscache

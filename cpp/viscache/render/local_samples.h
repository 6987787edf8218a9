#pragma once
// Light samples that belong to one eye point alone: area lights, environment, ambient occlusion.
#include <vector>

#include "viscache/render/eye_paths.h"
#include "viscache/render/settings.h"
#include "viscache/visibility/local_samples.h"

namespace viscache {

/// Samples with what each brings when it is unoccluded.
struct WeightedSamples {
    LocalSamples at;
    std::vector<Rgb>
        contribution;  ///< throughput · f · cos · L / (pdf · samples); RGB = fraction for ambient
    /// Starts anew, for a light group and what its samples are.
    void begin(Semantic semantic, LightGroup group) {
        at.clear();
        contribution.clear();
        at.semantic = semantic;
        at.group = int(group);
    }
    /// Keeps the sample when it brings something; non-finite contributions are dropped and counted.
    bool add(Vec3 to, Rgb value, float density, float light_density, Counters& counters);
};

/// A query of one eye point's own direction.
ShadowQuery query_towards(uint32_t eye, Vec3 direction, LightGroup group, float density,
                          float t_max = kInfinity);

// Each adds the samples of one eye point and closes its row.
void add_area_samples(const Scene& scene, const EyeTile& eyes, uint32_t eye,
                      const IntegratorSettings& settings, uint64_t seed, WeightedSamples& out,
                      Counters& counters);
void add_environment_samples(const Scene& scene, const EyeTile& eyes, uint32_t eye,
                             const IntegratorSettings& settings, uint64_t seed, WeightedSamples& out,
                             Counters& counters);
void add_ambient_samples(const EyeTile& eyes, uint32_t eye, const IntegratorSettings& settings, uint64_t seed,
                         WeightedSamples& out);

}  // namespace viscache

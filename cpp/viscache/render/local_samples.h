#pragma once
// Light samples that belong to one eye point alone: area lights, environment, ambient occlusion.
#include <vector>

#include "viscache/render/eye_paths.h"
#include "viscache/render/settings.h"

namespace viscache {

/// Connections with what each brings when it is unoccluded.
struct LocalQueries {
    std::vector<ShadowQuery> queries;
    std::vector<Rgb>
        contribution;  ///< throughput · f · cos · L / (pdf · samples); RGB = fraction for ambient
    void clear() { queries.clear(), contribution.clear(); }
    /// Keeps the query when it brings something; non-finite contributions are dropped and counted.
    void add(const ShadowQuery& query, Rgb value, Counters& counters);
};

/// A query of one eye point's own direction.
ShadowQuery query_towards(uint32_t eye, Vec3 direction, LightGroup group, float density,
                          float t_max = kInfinity);

void add_area_samples(const Scene& scene, const EyeTile& eyes, uint32_t eye,
                      const IntegratorSettings& settings, uint64_t seed, LocalQueries& out,
                      Counters& counters);
void add_environment_samples(const Scene& scene, const EyeTile& eyes, uint32_t eye,
                             const IntegratorSettings& settings, uint64_t seed, LocalQueries& out,
                             Counters& counters);
void add_ambient_samples(const EyeTile& eyes, uint32_t eye, const IntegratorSettings& settings, uint64_t seed,
                         LocalQueries& out);

}  // namespace viscache

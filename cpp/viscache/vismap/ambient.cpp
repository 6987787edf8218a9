#include "viscache/vismap/ambient.h"

#include <cmath>

namespace viscache {

AmbientShade shade_ambient(const MapCache& cache, const CachePoint& point, const AmbientRules& rules,
                           NeighbourList& around) {
    const MapCacheParameters& p = cache.parameters();
    NearestSet set(p.m_nearest, point.d_max);
    const auto found = cache.candidates(point, set, around);
    const NormalizedWeight normalized(p.theta_max_rad(), float(p.lambda));
    // Distances are measured in d_max, which grows with the pixel's footprint, so the blur is the same in
    // pixels.
    const double sigma = double(rules.width) * double(point.d_max);
    double sum = 0, total = 0, gaussian = 0;
    for (const NearestSet::Found& f : found) {
        // Found in order of distance: after the loop, `gaussian` is that of the farthest record.
        const double d = std::sqrt(double(f.distance2()));
        gaussian = std::exp(-0.5 * d * d / (sigma * sigma));
        double weight = gaussian;
        // The Gaussian ignores normals; w_g·ŵ is the weight with which maps are blended.
        if (rules.weighted)
            weight *= double(
                normalized(float(d) / point.d_max, normal_angle(point.normal, f.point->normal)) *
                geometric_weight(point.normal, f.point->position - point.position, float(d), point.d_max));
        sum += weight * double(cache.records().ambient(f.id()).visibility);
        total += weight;
    }
    AmbientShade shade;
    if (!(total > 0)) return shade;
    shade.visibility = float(sum / total);
    shade.records = int(found.size());
    // With all m records taken, the farthest one may be replaced by another from one pixel to the next.
    shade.jump = int(found.size()) == p.m_nearest ? float(gaussian) : 0.f;
    return shade;
}

}  // namespace viscache

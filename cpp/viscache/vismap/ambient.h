#pragma once
// Ambient occlusion interpolated from values stored with the records.
#include "viscache/vismap/map_cache.h"

namespace viscache {

struct AmbientRules {
    float width = 1.f / 6;  ///< σ of the Gaussian, as a fraction of d_max
    bool weighted = false;  ///< true: multiplied by w_g·ŵ
};

struct AmbientShade {
    float visibility = 0;  ///< A, the Gaussian mean over the m nearest records
    int records = 0;       ///< number of averaged records; 0: none in reach, visibility is 0
    /// Gaussian at the farthest record if m records are nearer than d_max, otherwise 0. Bounds the
    /// discontinuity where the set of records changes, relative to a record at the point.
    float jump = 0;
};

AmbientShade shade_ambient(const MapCache& cache, const CachePoint& point, const AmbientRules& rules,
                           NeighbourList& around);

}  // namespace viscache

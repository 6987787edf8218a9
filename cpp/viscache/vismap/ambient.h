#pragma once
// Ambient occlusion from values that records hold ready.
#include "viscache/vismap/map_cache.h"

namespace viscache {

struct AmbientRules {
    float width = 1.f / 6;  ///< σ of the Gaussian, in d_max
    bool weighted = false;  ///< times w_g·ŵ
};

struct AmbientShade {
    float visibility = 0;  ///< A, the Gaussian mean over the m nearest records
    int records = 0;       ///< averaged; 0: none in reach, visibility is 0
    /// Gaussian at the farthest record where m of them are nearer than d_max, else 0: by so much the result
    /// may jump where the set changes, relative to a record at the point.
    float jump = 0;
};

AmbientShade shade_ambient(const MapCache& cache, const CachePoint& point, const AmbientRules& rules,
                           NeighbourList& around);

}  // namespace viscache

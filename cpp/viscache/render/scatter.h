#pragma once
// One bounce of a sub-path.
#include <optional>

#include "viscache/render/path_vertex.h"
#include "viscache/sampling/rng.h"

namespace viscache {

enum class Transport { kRadiance, kImportance };  ///< carried by eye paths; by light paths

/// Adjoint of shading with normal n on a surface with normal ng (Veach 1997, Sec. 5.3): photons arrive and
/// leave in proportion to the cosines to ng, radiance reckons with those to n. One where n = ng.
inline float adjoint(Vec3 n, Vec3 ng, Vec3 wi, Vec3 wo) {
    return std::fabs(dot(wi, n) * dot(wo, ng) / (dot(wi, ng) * dot(wo, n)));
}

struct Scatter {
    Vec3 direction;       ///< unit
    Vec3 side;            ///< geometric normal on the side it leaves to
    Rgb factor;           ///< of the throughput
    double pdf = 0;       ///< per sr; of a mirror or glass the probability of the event
    double pdf_back = 0;  ///< the same of the way back
    bool specular = false;
};

/// Draws the direction in which the sub-path goes on; empty where it ends.
std::optional<Scatter> scatter(const PathVertex& v, Transport transport, Rng& rng);

}  // namespace viscache

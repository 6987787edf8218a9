#pragma once
// One bounce of a sub-path.
#include <optional>

#include "viscache/render/path_vertex.h"
#include "viscache/sampling/rng.h"

namespace viscache {

enum class Transport { kRadiance, kImportance };  ///< of eye paths; of light paths

/// Correction for light paths where the shading normal n differs from the geometric normal ng (Veach 1997,
/// Sec. 5.3). Photons arrive and leave in proportion to the cosines to ng, radiance in proportion to those to
/// n. The factor is one where n = ng.
inline float adjoint(Vec3 n, Vec3 ng, Vec3 wi, Vec3 wo) {
    return std::fabs(dot(wi, n) * dot(wo, ng) / (dot(wi, ng) * dot(wo, n)));
}

struct Scatter {
    Vec3 direction;       ///< unit
    Vec3 side;            ///< geometric normal on the side of `direction`
    Rgb factor;           ///< factor of the throughput
    double pdf = 0;       ///< per sr; for mirror and glass the probability of the event
    double pdf_back = 0;  ///< the same for the way back
    bool specular = false;
};

/// Draws the next direction of the sub-path. Empty where it ends.
std::optional<Scatter> scatter(const PathVertex& v, Transport transport, Rng& rng);

}  // namespace viscache

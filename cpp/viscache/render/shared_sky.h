#pragma once
// The environment as directions that all eye points share.
#include "viscache/render/shared_lights.h"
#include "viscache/scene/envmap.h"

namespace viscache {

/// n directions drawn by the environment's radiance, once for a frame: each brings the irradiance L/(n·pdf).
/// The expectation over seeds is that of samples of each eye point's own; errors show as bands, not as noise.
/// Directions near each other follow each other.
SharedLights shared_sky(const EnvironmentMap& environment, int n, uint64_t seed);

}  // namespace viscache

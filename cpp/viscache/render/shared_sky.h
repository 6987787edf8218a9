#pragma once
// The environment as directions that all eye points share.
#include "viscache/render/shared_lights.h"
#include "viscache/scene/envmap.h"

namespace viscache {

/// Draws n directions by the radiance of the environment, once per frame. Each has the irradiance L/(n·pdf).
/// The expectation over seeds equals that of separate samples per eye point; errors show as bands, not as
/// noise. Nearby directions are stored together.
SharedLights shared_sky(const EnvironmentMap& environment, int n, uint64_t seed);

}  // namespace viscache

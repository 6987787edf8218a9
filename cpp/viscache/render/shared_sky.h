#pragma once
// The environment as directions that all eye points share.
#include "viscache/render/shared_lights.h"
#include "viscache/scene/envmap.h"

namespace viscache {

/// Draws n directions by the radiance of the environment, once per frame. The expectation over seeds equals
/// that of separate samples per eye point; errors show as bands, not as noise. Nearby directions are stored
/// together.
///
/// With several sets, the directions are dealt to them, and the eye points of a pixel ask the sets in turns:
/// interleaved sampling (Keller and Heidrich 2001) over the samples of a pixel. A direction has the
/// irradiance L/(m·pdf), where m is the size of its set.
SharedLights shared_sky(const EnvironmentMap& environment, int n, int sets, uint64_t seed);

}  // namespace viscache

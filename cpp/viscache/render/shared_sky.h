#pragma once
// The environment as directions that all eye points share.
#include "viscache/render/settings.h"
#include "viscache/render/shared_lights.h"
#include "viscache/scene/envmap.h"

namespace viscache {

/// How many of n directions or samples one of the sets has to which they are dealt.
inline int set_size(int n, int sets, size_t set) {
    return int(size_t(n) * (set + 1) / size_t(sets) - size_t(n) * set / size_t(sets));
}

/// Draws `n_environment` directions by the radiance of the environment, once per frame. The expectation over
/// seeds equals that of separate samples per eye point; errors show as bands, not as noise. Nearby directions
/// are stored together.
///
/// With several sets, the directions are dealt to them, and the eye points of a pixel ask the sets in turns:
/// interleaved sampling (Keller and Heidrich 2001) over the samples of a pixel. A direction has the
/// irradiance L/(m·pdf), where m is the size of its set.
///
/// `n_brdf` samples of lobes are dealt to the sets as well. Where a set has b of them, eye points with
/// a sharp lobe weight its directions by m·pdf/(m·pdf + b·pdf_lobe) (balance heuristic, Veach and Guibas
/// 1995; `add_lobe_samples`).
SharedLights shared_sky(const EnvironmentMap& environment, const IntegratorSettings& settings, uint64_t seed);

}  // namespace viscache

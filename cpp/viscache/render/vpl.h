#pragma once
// Virtual point lights (instant radiosity, Keller 1997), resampled to a given number by their contribution to
// the camera (after Segovia et al. 2006). They carry indirect light only and reflect diffusely. On glossy
// surfaces they use the diffuse part of the albedo, which is the base colour without the share of the lobe.
// Light arrives by the shading normal, as for eye paths. A VPL emits like a patch with the geometric normal.
#include "viscache/math/parallel.h"
#include "viscache/render/settings.h"
#include "viscache/render/shared_lights.h"
#include "viscache/scene/film_camera.h"
#include "viscache/scene/scene.h"
#include "viscache/visibility/ray_caster.h"

namespace viscache {

struct Vpl {
    Vec3 position;
    Vec3 normal;  ///< unit geometric normal on the lit side
    Rgb flux;     ///< reflected radiant exitance × area / π: contribution = f · flux · cos·cos'/(d² + bound²)
    float extent = -1;  ///< of its surface (scene/surface_extent.h); < 0: not known, take that of the scene
};

/// Traces about `candidates` VPLs, with as many light paths as that needs (up to a limit per candidate).
/// Their sum estimates the indirect light for any number of VPLs.
std::vector<Vpl> trace_vpls(const Scene& scene, const RayCaster& caster, size_t candidates, int max_depth,
                            uint64_t seed, int threads, Control& control, Counters& counters);

/// Selects `wanted` candidates with probability by their exact contribution to camera points. A small part of
/// the probability follows flux, so that every light can be selected. The expectation of the sum is
/// unchanged. A candidate that is selected several times is stored once.
std::vector<Vpl> resample_vpls(const std::vector<Vpl>& candidates, size_t wanted, const Scene& scene,
                               const RayCaster& caster, const FilmCamera& film,
                               const IntegratorSettings& settings, const FrameSettings& frame,
                               Control& control, Counters& counters);

/// D_l: density of light samples at each VPL, estimated from the set itself as 4/(π r₄²). r₄ is the distance
/// to the fourth nearest VPL with a compatible normal.
std::vector<float> vpl_densities(const std::vector<Vpl>& vpls, int threads, Control& control);

}  // namespace viscache

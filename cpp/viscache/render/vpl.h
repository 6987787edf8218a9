#pragma once
// Virtual point lights (instant radiosity, Keller 1997), resampled to a user's number by what they bring to
// the camera (after Segovia et al. 2006 [SP06]). They carry indirect light only, and reflect diffusely: on
// glossy surfaces the diffuse part of the albedo, which is less than the base colour by what the lobe takes.
// Light arrives by the shading normal, as for eye paths; a VPL shines like a patch with the geometric one.
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
};

/// About `candidates` VPLs, from as many light paths as that takes (at most 256 each); their sum estimates
/// the indirect light, whatever their number.
std::vector<Vpl> trace_vpls(const Scene& scene, const RayCaster& caster, size_t candidates, int max_depth,
                            uint64_t seed, int threads, Control& control, Counters& counters);

/// Keeps `wanted` of the candidates with probability by their exact contribution to camera points (with a
/// floor of 10 % by flux, so that every light keeps a chance); the sum's expectation stays. Equal picks are
/// merged.
std::vector<Vpl> resample_vpls(const std::vector<Vpl>& candidates, size_t wanted, const Scene& scene,
                               const RayCaster& caster, const FilmCamera& film,
                               const IntegratorSettings& settings, const FrameSettings& frame,
                               Control& control, Counters& counters);

/// D_l of VPLs, from the set itself: 4/(π r₄²), r₄ = distance to the fourth nearest with a compatible normal
/// estimates the density of light samples at the VPL.
std::vector<float> vpl_densities(const std::vector<Vpl>& vpls, int threads, Control& control);

}  // namespace viscache

// The lights that all eye points of a frame share.
#include "viscache/math/morton.h"
#include "viscache/render/frame.h"
#include "viscache/render/shared_sky.h"
#include "viscache/render/vpl.h"

namespace viscache {

namespace {

/// Traces and resamples the virtual point lights of the frame.
std::vector<Vpl> make_vpls(const Scene& scene, const RayCaster& caster, const FilmCamera& film,
                           const IntegratorSettings& integrator, const FrameSettings& frame, Control& control,
                           Counters& counters) {
    const size_t n = size_t(integrator.n_vpls);
    // More candidates than lights, of which those are kept that reach what the camera sees
    const auto candidates = trace_vpls(scene, caster, n * kVplCandidates, integrator.vpl_max_depth,
                                       frame.seed, frame.threads, control, counters);
    return resample_vpls(candidates, n, scene, caster, film, integrator, frame, control, counters);
}

}  // namespace

std::vector<SharedLights> make_shared_lights(const Scene& scene, const RayCaster& caster,
                                             const FilmCamera& film, const IntegratorSettings& integrator,
                                             const FrameSettings& frame, Control& control,
                                             Counters& counters) {
    std::vector<SharedLights> groups;
    const SceneDescription& d = scene.description();
    auto keep = [&](SharedLights& lights, Semantic semantic, LightGroup group) {
        // A group without lights would cost every tile a pass, and the frame an empty layer
        if (lights.empty()) return;
        lights.ends.semantic = semantic;
        lights.ends.group = int(group);
        lights.pad();
        groups.push_back(std::move(lights));
    };
    if (integrator.direct) {
        SharedLights points, directions;
        std::vector<Vec3> places;
        for (const PointLight& l : d.point_lights) places.push_back(l.position);
        // Neighbouring lights in neighbouring columns: their rays meet the same triangles
        for (const uint32_t i : morton_order(places)) {
            const PointLight& l = d.point_lights[i];
            if (!(max_component(l.intensity) > 0)) continue;
            // Density 0: a lamp has no extent, so a cache's cells need none on its side
            points.add(l.position, {}, l.position, l.intensity, 0);
            points.set_cone(l.cone);
        }
        for (const DirectionalLight& l : d.directional_lights)
            if (max_component(l.irradiance) > 0)
                directions.add(l.direction, {}, l.direction, l.irradiance, 0);
        // Mirrors can never reflect towards a light without an extent
        points.punctual = true;
        directions.punctual = true;
        keep(points, Semantic::kPoint, LightGroup::kPoint);
        keep(directions, Semantic::kDirection, LightGroup::kDirectional);
        // Other ways to sample the sky belong to single eye points and have estimators of their own
        if (scene.environment() && integrator.environment == EnvironmentSampling::kShared) {
            SharedLights sky = shared_sky(*scene.environment(), integrator, frame.seed);
            keep(sky, Semantic::kDirection, LightGroup::kEnvironment);
        }
    }
    if (integrator.vpls || integrator.n_vpls > 0) {
        const auto vpls = integrator.vpls
                              ? *integrator.vpls
                              : make_vpls(scene, caster, film, integrator, frame, control, counters);
        const auto density = vpl_densities(vpls, frame.threads, control);
        SharedLights lights;
        const float bound = float(integrator.vpl_bound) * scene.bounds().diagonal();
        // Bounded geometry: a virtual light in a corner would be a bright spot otherwise
        lights.bound2 = bound * bound;
        // Nearby lights are stored together, because their rays meet the same triangles
        std::vector<Vec3> places;
        for (const Vpl& v : vpls) places.push_back(v.position);
        for (const uint32_t i : morton_order(places)) {
            const Vec3 end = spawn(vpls[i].position, vpls[i].normal,
                                   vpls[i].extent < 0 ? scene.offset_extent() : vpls[i].extent);
            lights.add(vpls[i].position, vpls[i].normal, end, vpls[i].flux, density[i]);
        }
        // The geometry factor treats VPLs as surfaces. The cache can key them as points (vpl_key)
        keep(lights, Semantic::kSurface, LightGroup::kVpl);
    }
    return groups;
}

}  // namespace viscache

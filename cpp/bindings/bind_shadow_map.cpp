// Frames whose point and directional lights are looked up in shadow maps.
#include <pybind11/stl.h>

#include "caster_queries.h"
#include "frame_dict.h"
#include "interrupt.h"
#include "viscache/scene/check.h"
#include "viscache/visibility/coherence_trial.h"
#include "viscache/visibility/shadow_map_oracle.h"

namespace viscache::bindings {

namespace {

double wall_seconds() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

ShadowMaps build_maps(const Scene& scene, const RayCaster& caster, std::span<const SharedLights> lights,
                      const ShadowMapSettings& settings, int threads, Control& control) {
    // Shared directions of the sky are samples, not lights: no maps
    std::vector<const FarEnds*> with_maps;
    for (const SharedLights& l : lights) {
        const auto group = LightGroup(l.ends.group);
        if (group == LightGroup::kPoint || group == LightGroup::kDirectional ||
            (group == LightGroup::kVpl && settings.vpls))
            with_maps.push_back(&l.ends);
    }
    const ShadowMapExtent extent{scene.center(), scene.radius(), scene.offset_extent()};
    return ShadowMaps(caster, extent, settings, with_maps, threads, control);
}

py::dict render(const Scene& scene, const RayCaster& caster, const Camera& camera,
                const IntegratorSettings& integrator, const FrameSettings& frame,
                const ShadowMapSettings& settings, const py::object& progress) {
    settings.validate();
    FrameResult result;
    std::optional<ShadowMaps> maps;
    double maps_s = 0;
    run_interruptible(
        [&](Control& control) {
            check_camera(camera);
            const double start = wall_seconds();
            // The frame's shared lights, once more and in the same order; their rays are counted by the frame
            IntegratorSettings wanted = integrator;
            if (!settings.vpls) wanted.n_vpls = 0;
            Counters uncounted;
            const auto lights = make_shared_lights(scene, caster, {camera, frame.width, frame.height}, wanted,
                                                   frame, control, uncounted);
            maps.emplace(build_maps(scene, caster, lights, settings, frame.threads, control));
            maps_s = wall_seconds() - start;
            result = render_frame(
                scene, caster, camera, integrator, frame,
                [&] { return std::make_unique<ShadowMapOracle>(*maps, caster, scene.offset_extent()); },
                control);
        },
        progress);
    for (int g = 0; g < kLightGroups; ++g) result.counters.group(g).rays += maps->rays(g);
    py::dict out = frame_dict(result);
    out["counters"]["shadow_maps"] = maps->maps(), out["counters"]["shadow_map_rays"] = maps->rays();
    out["counters"]["shadow_map_bytes"] = maps->bytes(), out["timings"]["shadow_maps_s"] = maps_s;
    return out;
}

/// The look-ups of one light in its map, for tests.
py::tuple lit_by_light(const RayCaster& caster, const ShadowMapSettings& settings, Vec3 far, bool direction,
                       const FloatArray& positions, const FloatArray& normals, Vec3 center, float radius,
                       int threads) {
    require_same_rows(positions, normals, "positions and normals");
    const auto p = vec3s(positions, "positions"), n = vec3s(normals, "normals");
    SharedLights light;
    light.add(far, {}, far, {1, 1, 1}, 0);
    light.ends.semantic = direction ? Semantic::kDirection : Semantic::kPoint;
    light.pad();
    const std::array<const FarEnds*, 1> lights{&light.ends};
    Control control;
    const ShadowMaps maps(caster, {center, radius, 2 * radius}, settings, lights, threads, control);
    py::array_t<bool> lit{py::ssize_t(p.size())};
    for (size_t first = 0; first < p.size(); first += 16) {
        Receivers16 r;
        for (size_t i = 0; i < 16; ++i) {
            const size_t at = std::min(first + i, p.size() - 1);
            r.x[i] = p[at].x, r.y[i] = p[at].y, r.z[i] = p[at].z;
            r.nx[i] = n[at].x, r.ny[i] = n[at].y, r.nz[i] = n[at].z;
        }
        const uint16_t bits = maps.lit16(light.ends, 0, r);
        for (size_t i = first; i < std::min(first + 16, p.size()); ++i)
            lit.mutable_at(py::ssize_t(i)) = bits >> (i - first) & 1;
    }
    const auto depth = maps.depths(light.ends, 0);
    const py::ssize_t side = settings.resolution;
    py::array_t<float> depths({py::ssize_t(depth.size()) / (side * side), side, side});
    std::copy(depth.begin(), depth.end(), depths.mutable_data());
    return py::make_tuple(lit, depths);
}

}  // namespace

void bind_shadow_map(py::module_& m) {
    py::class_<ShadowMapSettings>(m, "ShadowMapSettings", "See viscache.ShadowMap.")
        .def(py::init<>())
        .def_readwrite("resolution", &ShadowMapSettings::resolution)
        .def_readwrite("bias", &ShadowMapSettings::bias)
        .def_readwrite("slope_bias", &ShadowMapSettings::slope_bias)
        .def_readwrite("vpls", &ShadowMapSettings::vpls)
        .def_readwrite("max_bytes", &ShadowMapSettings::max_bytes)
        .def("validate", &ShadowMapSettings::validate);
    m.def("render_shadow_maps", &render, py::arg("scene"), py::arg("caster"), py::arg("camera"),
          py::arg("integrator"), py::arg("frame"), py::arg("settings"), py::kw_only(),
          py::arg("progress") = py::none());
    m.def(
        "lit_by_light",
        [](const RayCaster& caster, const ShadowMapSettings& settings, std::array<float, 3> far,
           bool direction, const FloatArray& positions, const FloatArray& normals,
           std::array<float, 3> center, float radius, int threads) {
            return lit_by_light(caster, settings, vec3(far), direction, positions, normals, vec3(center),
                                radius, threads);
        },
        py::arg("caster"), py::arg("settings"), py::arg("far"), py::kw_only(), py::arg("direction"),
        py::arg("positions"), py::arg("normals"), py::arg("center"), py::arg("radius"),
        py::arg("threads") = 1,
        "One light's map asked about points with unit normals: lit (N,), depths (faces, rows, columns). "
        "`far` is a place, or a unit direction towards the light (tests).");
}

}  // namespace viscache::bindings

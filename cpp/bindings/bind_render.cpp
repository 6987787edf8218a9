// Rendering frames.
#include <pybind11/native_enum.h>
#include <pybind11/stl.h>

#include "arrays.h"
#include "frame_dict.h"
#include "interrupt.h"
#include "viscache/aqvc/quantized_cache.h"
#include "viscache/render/frame.h"
#include "viscache/scene/check.h"
#include "viscache/visibility/exact.h"
#include "viscache/visibility/ray_caster.h"

namespace viscache::bindings {

namespace {

template <class T>
py::array_t<float> image_of(const FrameResult& f, const std::vector<T>& values) {
    const py::ssize_t channels = py::ssize_t(sizeof(T) / sizeof(float));
    py::array_t<float> a({py::ssize_t(f.height), py::ssize_t(f.width), channels});
    std::memcpy(a.mutable_data(), values.data(), values.size() * sizeof(T));
    return a;
}

py::dict counters_of(const FrameResult& f) {
    const Counters& c = f.counters;
    py::dict groups;
    for (int g = 0; g < kLightGroups; ++g)
        if (!f.groups[g].empty())
            groups[kLightGroupNames[g]] =
                py::dict(py::arg("queries") = c.groups[g].queries, py::arg("occluded") = c.groups[g].occluded,
                         py::arg("rays") = c.groups[g].rays);
    std::vector<uint64_t> levels(c.rays_per_level.begin(), c.rays_per_level.end());
    while (!levels.empty() && levels.back() == 0) levels.pop_back();
    uint64_t occluded = 0;
    for (const auto& g : c.groups) occluded += g.occluded;
    py::dict d;
    d["queries"] = c.queries(), d["occluded"] = occluded, d["rays"] = c.rays();
    d["ray_reduction"] = c.rays() ? double(c.queries()) / double(c.rays()) : 0.0;
    d["groups"] = groups, d["camera_rays"] = c.camera_rays, d["light_rays"] = c.light_rays;
    d["lost_throughput"] = c.lost_throughput / (double(f.width) * f.height * f.spp);
    d["rays_per_level"] = levels, d["leftover_rays"] = c.leftover_rays;
    d["lookups"] = c.lookups, d["hits"] = c.hits;
    d["neighbour_probes"] = c.neighbour_probes, d["nil_neighbours"] = c.nil_neighbours;
    d["evictions"] = c.evictions, d["bypassed"] = c.bypassed;
    d["clamped_low"] = c.clamped_low, d["clamped_high"] = c.clamped_high, d["clamped_nan"] = c.clamped_nan;
    d["boundary_queries"] = c.boundary_queries, d["cells"] = c.cells;
    d["table_writes"] = c.table_writes, d["table_slots"] = c.table_slots;
    if (c.table_occupied) {
        d["table_occupied"] = c.table_occupied, d["duplicates"] = c.duplicates;
        d["occupancy"] = c.table_slots ? double(c.table_occupied) / double(c.table_slots) : 0.0;
    }
    d["expected_false_hits"] = c.expected_false_hits, d["non_finite"] = c.non_finite, d["vpls"] = f.n_vpls;
    if (c.product_points) {
        d["product_points"] = c.product_points, d["product_dark"] = c.product_dark;
        d["product_guided"] = c.product_guided, d["product_unserved"] = c.product_unserved;
        d["greatest_ratio"] = c.greatest_ratio, d["pilot_rays"] = c.pilot_rays;
    }
    if (f.forecast) {
        d["pilot_alpha"] = f.forecast->alpha, d["pilot_variance_ratio"] = f.forecast->variance_ratio;
        d["pilot_guided"] = f.forecast->guided;
    }
    return d;
}

FrameResult render(const Scene& scene, const RayCaster& caster, const Camera& camera,
                   const IntegratorSettings& integrator, const FrameSettings& frame,
                   const OracleFactory& oracle, const py::object& progress) {
    FrameResult result;
    run_interruptible(
        [&](Control& control) {
            result = render_frame(scene, caster, camera, integrator, frame, oracle, control);
        },
        progress);
    return result;
}

}  // namespace

py::dict frame_dict(const FrameResult& f) {
    py::dict layers, timings, out;
    layers["color"] = image_of(f, f.color), layers["emitted"] = image_of(f, f.emitted);
    for (int g = 0; g < kLightGroups; ++g)
        if (!f.groups[g].empty()) layers[kLightGroupNames[g]] = image_of(f, f.groups[g]);
    if (!f.last_pass.empty()) layers["environment_last_pass"] = image_of(f, f.last_pass);
    layers["depth"] = image_of(f, f.depth), layers["normal"] = image_of(f, f.normal);
    layers["albedo"] = image_of(f, f.albedo), layers["coverage"] = image_of(f, f.coverage);
    timings["lights_s"] = f.lights_s, timings["tiles_s"] = f.tiles_s;
    timings["eye_paths_cpu_s"] = f.stages.eye_paths, timings["contributions_cpu_s"] = f.stages.contributions;
    timings["visibility_cpu_s"] = f.stages.visibility, timings["shading_cpu_s"] = f.stages.shading;
    if (f.counters.product_points) {
        timings["trees_cpu_s"] = f.product.trees, timings["maps_cpu_s"] = f.product.maps;
        timings["samples_cpu_s"] = f.product.samples, timings["pilot_s"] = f.pilot_s;
    }
    out["layers"] = layers, out["timings"] = timings, out["counters"] = counters_of(f);
    if (!f.tile_sums.empty()) out["tile_sums"] = f.tile_sums;
    out["threads"] = f.threads, out["tile_edge_px"] = f.tile_edge_px;
    return out;
}

void bind_render(py::module_& m) {
    py::native_enum<PMode>(m, "PMode", "enum.Enum", "Where the density of an eye point comes from.")
        .value("LAST_VERTEX", PMode::kLastVertex)
        .value("FOOTPRINT", PMode::kFootprint)
        .finalize();
    py::native_enum<EnvironmentSampling>(m, "EnvironmentSampling", "enum.Enum",
                                         "How the environment is sampled.")
        .value("MIS", EnvironmentSampling::kMis)
        .value("PRODUCT", EnvironmentSampling::kProduct)
        .value("SHARED", EnvironmentSampling::kShared)
        .finalize();
    py::native_enum<AmbientEngine>(m, "AmbientEngine", "enum.Enum", "Who traces shared directions.")
        .value("AUTO", AmbientEngine::kAuto)
        .value("BATCH", AmbientEngine::kBatch)
        .value("EMBREE", AmbientEngine::kEmbree)
        .value("FIELD", AmbientEngine::kField)
        .finalize();
    py::native_enum<PointSet>(m, "PointSet", "enum.Enum", "Points of the square.")
        .value("INDEPENDENT", PointSet::kIndependent)
        .value("ZERO_TWO", PointSet::kZeroTwo)
        .finalize();
    py::native_enum<PacketOrder>(m, "PacketOrder", "enum.Enum", "Which exact shadow rays share a packet.")
        .value("BY_LIGHT", PacketOrder::kByLight)
        .value("BY_PIXEL", PacketOrder::kByPixel)
        .finalize();

    py::class_<IntegratorSettings>(m, "IntegratorSettings")
        .def(py::init<>())
        .def_readwrite("direct", &IntegratorSettings::direct)
        .def_readwrite("ambient", &IntegratorSettings::ambient)
        .def_readwrite("n_vpls", &IntegratorSettings::n_vpls)
        .def_readwrite("max_depth", &IntegratorSettings::max_depth)
        .def_readwrite("shade_after_specular", &IntegratorSettings::shade_after_specular)
        .def_readwrite("n_area", &IntegratorSettings::n_area)
        .def_readwrite("n_environment", &IntegratorSettings::n_environment)
        .def_readwrite("n_brdf", &IntegratorSettings::n_brdf)
        .def_readwrite("environment", &IntegratorSettings::environment)
        .def_readwrite("passes", &IntegratorSettings::passes)
        .def_readwrite("points", &IntegratorSettings::points)
        .def_readwrite("centred", &IntegratorSettings::centred)
        .def_readwrite("n_ambient", &IntegratorSettings::n_ambient)
        .def_readwrite("ambient_cosine", &IntegratorSettings::ambient_cosine)
        .def_readwrite("ambient_max_distance", &IntegratorSettings::ambient_max_distance)
        .def_readwrite("ambient_aligned", &IntegratorSettings::ambient_aligned)
        .def_readwrite("ambient_engine", &IntegratorSettings::ambient_engine)
        .def_readwrite("vpl_max_depth", &IntegratorSettings::vpl_max_depth)
        .def_readwrite("vpl_candidates", &IntegratorSettings::vpl_candidates)
        .def_readwrite("vpl_eye_points", &IntegratorSettings::vpl_eye_points)
        .def_readwrite("vpl_bound", &IntegratorSettings::vpl_bound)
        .def_readwrite("p_mode", &IntegratorSettings::p_mode)
        .def_readwrite("cosmin", &IntegratorSettings::cosmin);
    py::class_<FrameSettings>(m, "FrameSettings")
        .def(py::init<>())
        .def_readwrite("width", &FrameSettings::width)
        .def_readwrite("height", &FrameSettings::height)
        .def_readwrite("spp", &FrameSettings::spp)
        .def_readwrite("seed", &FrameSettings::seed)
        .def_readwrite("threads", &FrameSettings::threads)
        .def_readwrite("part", &FrameSettings::part)
        .def_readwrite("parts", &FrameSettings::parts);
    py::class_<Camera>(m, "Camera", "A pinhole camera; made by `viscache.look_at` or a scene file.")
        .def_readwrite("name", &Camera::name, "As the file names it.")
        .def_readwrite("fov_rad", &Camera::fov_y_rad, "Full angle of view, radians.")
        .def_readwrite("fov_is_horizontal", &Camera::fov_is_horizontal,
                       "Whether `fov_rad` is across the width instead of the height.")
        .def_readwrite("width", &Camera::width, "Pixels.")
        .def_readwrite("height", &Camera::height, "Pixels.")
        .def_property_readonly(
            "origin", [](const Camera& c) { return array3(c.origin); }, "Where it is, scene units.")
        .def_property_readonly(
            "forward", [](const Camera& c) { return array3(c.forward); }, "Where it looks, unit.")
        .def_property_readonly(
            "right", [](const Camera& c) { return array3(c.right); }, "Right in the picture, unit.")
        .def_property_readonly(
            "up", [](const Camera& c) { return array3(c.up); }, "Up in the picture, unit.");
    m.def("scene_cameras", [](const Scene& s) { return s.description().cameras; }, py::arg("scene"));
    m.def(
        "look_at",
        [](std::array<float, 3> origin, std::array<float, 3> target, std::array<float, 3> up, float fov_deg) {
            const Camera camera = look_at(vec3(origin), vec3(target), vec3(up), fov_deg * kPi / 180);
            check_camera(camera);
            return camera;
        },
        py::arg("origin"), py::arg("target"), py::arg("up"), py::arg("fov_deg"),
        "Pinhole camera at `origin` looking at `target`; `fov_deg` is the vertical angle of view.");
    m.def(
        "render_exact",
        [](const Scene& scene, const RayCaster& caster, const Camera& camera,
           const IntegratorSettings& integrator, const FrameSettings& frame, std::optional<PacketOrder> order,
           std::optional<bool> coherent, const py::object& progress) {
            std::optional<Coherence> flag;
            if (coherent) flag = *coherent ? Coherence::kCoherent : Coherence::kIncoherent;
            return frame_dict(render(
                scene, caster, camera, integrator, frame,
                [&] { return std::make_unique<ExactOracle>(caster, scene.offset_extent(), order, flag); },
                progress));
        },
        py::arg("scene"), py::arg("caster"), py::arg("camera"), py::arg("integrator"), py::arg("frame"),
        py::kw_only(), py::arg("order") = py::none(), py::arg("coherent") = py::none(),
        py::arg("progress") = py::none());
    m.def(
        "render_aqvc",
        [](const Scene& scene, const RayCaster& caster, const Camera& camera,
           const IntegratorSettings& integrator, FrameSettings frame, const AqvcParameters& parameters,
           const py::object& progress) {
            parameters.validate();
            frame.paper_tiles = parameters.storage == Storage::kPaperTiles;
            return frame_dict(render(
                scene, caster, camera, integrator, frame,
                [&] {
                    return std::make_unique<QuantizedCache>(caster, parameters, scene.center(),
                                                            scene.radius(), scene.offset_extent(), frame.spp);
                },
                progress));
        },
        py::arg("scene"), py::arg("caster"), py::arg("camera"), py::arg("integrator"), py::arg("frame"),
        py::arg("parameters"), py::kw_only(), py::arg("progress") = py::none());
}

}  // namespace viscache::bindings

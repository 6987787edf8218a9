// Frames by Next Event Estimation++: a small frame learns the map of visibilities, then Russian roulette.
#include <pybind11/stl.h>

#include "caster_queries.h"
#include "frame_dict.h"
#include "interrupt.h"
#include "viscache/render/bdpt.h"
#include "viscache/scene/check.h"
#include "viscache/visibility/roulette_oracle.h"

namespace viscache::bindings {

namespace {

double wall_seconds() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// The frame that learns: of that many pixels or a few more, at most those of the frame; one sample each.
FrameSettings learning_frame(FrameSettings frame, int pixels) {
    const double scale = std::min(1.0, std::sqrt(double(pixels) / (double(frame.width) * frame.height)));
    frame.width = int(std::ceil(frame.width * scale)), frame.height = int(std::ceil(frame.height * scale));
    frame.spp = 1;
    return frame;
}

/// `render(frame, make_oracle, control)` renders a frame of any size with any oracles.
template <class Render>
py::dict learn_and_render(const Scene& scene, const RayCaster& caster, const FrameSettings& frame,
                          const NeePlusPlusSettings& settings, bool weighted, const py::object& progress,
                          Render render) {
    settings.validate();
    VoxelVisibility map(scene.bounds(), settings);
    FrameResult learnt, result;
    double learn_s = 0;
    const float extent = scene.offset_extent();
    run_interruptible(
        [&](Control& control) {
            const double start = wall_seconds();
            learnt = render(
                learning_frame(frame, settings.learn_pixels),
                [&] { return std::make_unique<LearningOracle>(map, caster, extent); }, control);
            learn_s = wall_seconds() - start;
            control.done = 0;
            result = render(
                frame,
                [&] { return std::make_unique<RouletteOracle>(map, caster, extent, frame.seed, weighted); },
                control);
        },
        progress);
    const uint64_t traced = result.counters.rays();
    for (int g = 0; g < kLightGroups; ++g) result.counters.group(g).rays += learnt.counters.group(g).rays;
    result.counters.light_rays += learnt.counters.light_rays;
    result.counters.camera_rays += learnt.counters.camera_rays;
    result.stages.merge(learnt.stages);
    py::dict out = frame_dict(result);
    out["counters"]["discarded"] = result.counters.queries() - traced;
    out["counters"]["learning_rays"] = learnt.counters.rays();
    out["counters"]["voxel_pairs"] = map.pairs_tested(), out["counters"]["map_bytes"] = map.bytes();
    out["timings"]["learning_s"] = learn_s;
    return out;
}

py::dict render_light(const Scene& scene, const RayCaster& caster, const Camera& camera,
                      const IntegratorSettings& integrator, const FrameSettings& frame,
                      const NeePlusPlusSettings& settings, bool weighted, const py::object& progress) {
    return learn_and_render(scene, caster, frame, settings, weighted, progress,
                            [&](const FrameSettings& size, const OracleFactory& make, Control& control) {
                                return render_frame(scene, caster, camera, integrator, size, make, control);
                            });
}

py::dict render_paths(const Scene& scene, const RayCaster& caster, const Camera& camera,
                      const BdptSettings& bdpt, const FrameSettings& frame,
                      const NeePlusPlusSettings& settings, bool weighted, const py::object& progress) {
    return learn_and_render(scene, caster, frame, settings, weighted, progress,
                            [&](const FrameSettings& size, const OracleFactory& make, Control& control) {
                                return render_bdpt(scene, caster, camera, bdpt, size,
                                                   RoundOracles{.make = make}, control);
                            });
}

/// A map over a box, filled with given connections, for tests.
py::tuple learnt_map(const NeePlusPlusSettings& settings, std::array<float, 3> low, std::array<float, 3> high,
                     const FloatArray& near, const FloatArray& far,
                     const py::array_t<bool, py::array::c_style | py::array::forcecast>& seen,
                     bool direction) {
    require_same_rows(near, far, "near and far");
    const auto from = vec3s(near, "near"), to = vec3s(far, "far");
    if (seen.ndim() != 1 || size_t(seen.size()) != from.size())
        throw std::invalid_argument("seen must have one value per row of near");
    VoxelVisibility map({vec3(low), vec3(high)}, settings);
    const Semantic semantic = direction ? Semantic::kDirection : Semantic::kPoint;
    const py::ssize_t n = py::ssize_t(from.size());
    py::array_t<uint32_t> near_cell(n), far_cell(n);
    for (py::ssize_t i = 0; i < n; ++i) {
        near_cell.mutable_at(i) = map.voxel(from[size_t(i)]);
        far_cell.mutable_at(i) = map.far_cell(semantic, to[size_t(i)]);
        map.add(near_cell.at(i), far_cell.at(i), seen.at(i));
    }
    py::array_t<double> visibility(n), probability(n);
    for (py::ssize_t i = 0; i < n; ++i) {
        visibility.mutable_at(i) = map.visibility(near_cell.at(i), far_cell.at(i));
        probability.mutable_at(i) = map.probability(near_cell.at(i), far_cell.at(i));
    }
    return py::make_tuple(near_cell, far_cell, visibility, probability);
}

}  // namespace

void bind_nee_plus_plus(py::module_& m) {
    py::class_<NeePlusPlusSettings>(m, "NeePlusPlusSettings", "See viscache.NeePlusPlus.")
        .def(py::init<>())
        .def_readwrite("n_voxels", &NeePlusPlusSettings::n_voxels)
        .def_readwrite("n_directions", &NeePlusPlusSettings::n_directions)
        .def_readwrite("learn_pixels", &NeePlusPlusSettings::learn_pixels)
        .def_readwrite("min_probability", &NeePlusPlusSettings::min_probability)
        .def_readwrite("exponent", &NeePlusPlusSettings::exponent)
        .def_readwrite("symmetric", &NeePlusPlusSettings::symmetric)
        .def_readwrite("max_bytes", &NeePlusPlusSettings::max_bytes)
        .def("validate", &NeePlusPlusSettings::validate);
    m.def("render_nee_plus_plus", &render_light, py::arg("scene"), py::arg("caster"), py::arg("camera"),
          py::arg("integrator"), py::arg("frame"), py::arg("settings"), py::kw_only(),
          py::arg("weighted") = true, py::arg("progress") = py::none());
    m.def("render_bdpt_nee_plus_plus", &render_paths, py::arg("scene"), py::arg("caster"), py::arg("camera"),
          py::arg("integrator"), py::arg("frame"), py::arg("settings"), py::kw_only(),
          py::arg("weighted") = true, py::arg("progress") = py::none());
    m.def("learnt_map", &learnt_map, py::arg("settings"), py::arg("low"), py::arg("high"), py::arg("near"),
          py::arg("far"), py::arg("seen"), py::kw_only(), py::arg("direction") = false,
          "Cells of both ends (N,), then visibility and probability of each connection once all are counted "
          "(tests). `far` holds places, or directions towards the light.");
}

}  // namespace viscache::bindings

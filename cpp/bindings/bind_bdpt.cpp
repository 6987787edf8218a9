// Bidirectional path tracing.
#include <pybind11/native_enum.h>
#include <pybind11/stl.h>

#include "frame_dict.h"
#include "interrupt.h"
#include "viscache/aqvc/quantized_cache.h"
#include "viscache/render/bdpt.h"
#include "viscache/visibility/exact.h"
#include "viscache/visibility/ray_caster.h"

namespace viscache::bindings {
namespace {

namespace py = pybind11;

py::dict render(const Scene& scene, const RayCaster& caster, const Camera& camera,
                const BdptSettings& settings, const FrameSettings& frame, const RoundOracles& oracles,
                const py::object& progress) {
    FrameResult result;
    run_interruptible(
        [&](Control& control) {
            result = render_bdpt(scene, caster, camera, settings, frame, oracles, control);
        },
        progress);
    return frame_dict(result);
}

/// Caches over one table of the frame.
RoundOracles caches(const Scene& scene, const RayCaster& caster, const FrameSettings& frame,
                    const AqvcParameters& parameters, FrameTable& table) {
    return {.make =
                [&, spp = frame.spp] {
                    return std::make_unique<QuantizedCache>(caster, parameters, scene.center(),
                                                            scene.radius(), scene.offset_extent(), spp,
                                                            &table);
                },
            .begin_round = [&](size_t items) { table.begin_round(items); },
            .end_item = [&](VisibilityOracle& oracle,
                            size_t item) { table.keep(item, static_cast<QuantizedCache&>(oracle).writes()); },
            .end_round = [&](Counters& counters) { table.end_round(counters); }};
}

}  // namespace

void bind_bdpt(py::module_& m) {
    py::native_enum<CameraConnections>(m, "CameraConnections", "enum.Enum",
                                       "Light paths that are connected to the camera.")
        .value("BYPASS", CameraConnections::kBypass)
        .value("KEYED", CameraConnections::kKeyed)
        .value("OFF", CameraConnections::kOff)
        .finalize();
    py::class_<BdptSettings>(m, "BdptSettings")
        .def(py::init<>())
        .def_readwrite("max_depth", &BdptSettings::max_depth)
        .def_readwrite("camera_connections", &BdptSettings::camera_connections)
        .def_readwrite("cosmin", &BdptSettings::cosmin);
    m.def(
        "render_bdpt_exact",
        [](const Scene& scene, const RayCaster& caster, const Camera& camera, const BdptSettings& settings,
           const FrameSettings& frame, std::optional<PacketOrder> order, std::optional<bool> coherent,
           const py::object& progress) {
            std::optional<Coherence> flag;
            if (coherent) flag = *coherent ? Coherence::kCoherent : Coherence::kIncoherent;
            const RoundOracles oracles{.make = [&] {
                return std::make_unique<ExactOracle>(caster, scene.offset_extent(), order, flag);
            }};
            return render(scene, caster, camera, settings, frame, oracles, progress);
        },
        py::arg("scene"), py::arg("caster"), py::arg("camera"), py::arg("settings"), py::arg("frame"),
        py::kw_only(), py::arg("order") = py::none(), py::arg("coherent") = py::none(),
        py::arg("progress") = py::none());
    m.def(
        "render_bdpt_aqvc",
        [](const Scene& scene, const RayCaster& caster, const Camera& camera, const BdptSettings& settings,
           const FrameSettings& frame, const AqvcParameters& parameters, const py::object& progress) {
            parameters.validate();
            FrameTable table(parameters);
            return render(scene, caster, camera, settings, frame,
                          caches(scene, caster, frame, parameters, table), progress);
        },
        py::arg("scene"), py::arg("caster"), py::arg("camera"), py::arg("settings"), py::arg("frame"),
        py::arg("parameters"), py::kw_only(), py::arg("progress") = py::none());
}

}  // namespace viscache::bindings

// Renders frames from tiles of eye points or from bidirectional paths. Both take any source of oracles.
#include <pybind11/pybind11.h>
#include <pybind11/typing.h>

#include "frame_dict.h"
#include "frame_maps.h"
#include "interrupt.h"
#include "viscache/render/bdpt.h"
#include "viscache/render/frame.h"
#include "viscache/vlf/directions.h"

namespace py = pybind11;

namespace viscache::bindings {

namespace {

/// The engines for the shared directions of ambient occlusion. Empty if the integrator has none.
std::optional<AlignedEngines> aligned_engines(const RayCaster& caster, const IntegratorSettings& integrator,
                                              const AlignedBatch* batch, const VisibilityField* field) {
    if (!integrator.ambient || integrator.ambient_directions == AmbientDirections::kPerPoint)
        return std::nullopt;
    // Shared directions are the axes of a set Ω_l, so their number must be one of its sizes.
    detail::require(is_direction_count(uint64_t(std::max(0, integrator.n_ambient))),
                    "n_samples must be a number of directions", integrator.n_ambient);
    if ((integrator.ambient_engine == AmbientEngine::kField) != (field != nullptr))
        throw py::value_error("a field must be given if and only if the integrator asks for it");
    // The batch is chosen against Embree's packets.
    const auto* embree = dynamic_cast<const EmbreeCaster*>(&caster);
    if (!embree) throw py::value_error("shared directions need Embree as ray caster");
    return AlignedEngines{batch, *embree, field};
}

/// The C++ object of a Python argument; nullptr for None.
template <class T>
const T* pointer(const py::object& given) {
    return given.is_none() ? nullptr : given.cast<const T*>();
}

/// The integrator with product samples of the environment, as visibility maps need them.
IntegratorSettings with_product(const Scene& scene, IntegratorSettings integrator, const VisMapSettings& s) {
    if (!scene.environment())
        throw py::value_error("scene must have an environment light for visibility maps");
    if (!integrator.direct || integrator.n_environment < 1)
        throw py::value_error("integrator must sample the environment's light, n_environment >= 1");
    // Leave-one-out needs independent samples: in an even set, each sample says where the others are.
    if (s.alpha.mode == AlphaMode::kLeaveOneOut && integrator.points != PointSet::kIndependent)
        throw py::value_error("points must be \"independent\" with alpha=\"loo\", got even");
    // The maps are a control variate of product sampling.
    integrator.environment = EnvironmentSampling::kProduct;
    return integrator;
}

py::dict render_tiles(const Scene& scene, const RayCaster& caster, const Camera& camera,
                      const IntegratorSettings& given_integrator, const FrameSettings& frame,
                      OracleSource& source, const py::typing::Optional<FrameMaps>& given_maps,
                      const py::typing::Optional<AlignedBatch>& batch,
                      const py::typing::Optional<VisibilityField>& field,
                      const py::typing::Optional<KeptLights>& kept_lights, const py::object& progress) {
    const auto* maps = pointer<FrameMaps>(given_maps);
    const IntegratorSettings integrator =
        maps ? with_product(scene, given_integrator, maps->maps.settings) : given_integrator;
    KeptLights* lights = kept_lights.is_none() ? nullptr : kept_lights.cast<KeptLights*>();
    const auto engines =
        aligned_engines(caster, integrator, pointer<AlignedBatch>(batch), pointer<VisibilityField>(field));
    // Everything Python has been read: the frame is rendered without the lock.
    FrameResult result = run_interruptible(
        [&](Control& control) {
            return render_frame(scene, caster, camera, integrator, frame, source, control,
                                maps ? &maps->maps : nullptr, engines ? &*engines : nullptr, lights);
        },
        progress);
    // With the lock again: the cache learns which records it used only when the frame is whole.
    if (result.tally && maps->take_tally) maps->take_tally(*result.tally);
    return frame_dict(result);
}

py::dict render_paths(const Scene& scene, const RayCaster& caster, const Camera& camera,
                      const BdptSettings& settings, const FrameSettings& frame, OracleSource& source,
                      const py::object& progress) {
    return frame_dict(run_interruptible(
        [&](Control& control) {
            return render_bdpt(scene, caster, camera, settings, frame, source, control);
        },
        progress));
}

}  // namespace

void bind_frames(py::module_& m) {
    py::class_<KeptLights>(m, "KeptLights",
                           "The shared lights of a frame, for frames of the same scene, integrator, size "
                           "and seed.")
        .def(py::init<>());
    m.def(
        "counter_rows",
        [] {
            py::dict docs;
            for_each_counter([&](const auto& row) { docs[row.name] = row.doc; });
            return docs;
        },
        "What each counter of a frame counts, by name.");
    m.def("render_frame", &render_tiles, py::arg("scene"), py::arg("caster"), py::arg("camera"),
          py::arg("integrator"), py::arg("frame"), py::arg("source"), py::kw_only(),
          py::arg("maps") = py::none(), py::arg("batch") = py::none(), py::arg("field") = py::none(),
          py::arg("lights") = py::none(), py::arg("progress") = py::none(),
          "A frame of direct light, virtual point lights or ambient occlusion. `source` serves one frame. "
          "`batch` and `field` may trace the shared directions of ambient occlusion. `lights` are kept for "
          "frames with the same shared lights.");
    m.def("render_bdpt", &render_paths, py::arg("scene"), py::arg("caster"), py::arg("camera"),
          py::arg("settings"), py::arg("frame"), py::arg("source"), py::kw_only(),
          py::arg("progress") = py::none(), "A frame of bidirectional paths. `source` serves one frame.");
}

}  // namespace viscache::bindings

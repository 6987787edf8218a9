// A table of the quantized cache that outlives frames.
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include "frame_dict.h"
#include "interrupt.h"
#include "viscache/aqvc/quantized_cache.h"
#include "viscache/render/frame.h"

namespace py = pybind11;

namespace viscache::bindings {

namespace {

/// A frame whose tiles read and extend `table`; an interrupted one writes nothing.
py::dict render_kept(const Scene& scene, const RayCaster& caster, const Camera& camera,
                     const IntegratorSettings& integrator, const FrameSettings& frame,
                     const AqvcParameters& parameters, KeptTable& table, double check, bool repair,
                     const py::object& progress) {
    parameters.validate();
    const OracleFactory make = [&] {
        auto cache = std::make_unique<QuantizedCache>(caster, parameters, scene.center(), scene.radius(),
                                                      scene.offset_extent(), frame.spp);
        cache->use_kept(table, {check, repair});
        return cache;
    };
    const TileDone done = [&](VisibilityOracle& oracle, size_t tile) {
        table.keep(tile, static_cast<QuantizedCache&>(oracle).kept_writes());
    };
    FrameResult result;
    run_interruptible(
        [&](Control& control) {
            table.begin_frame();
            result =
                render_frame(scene, caster, camera, integrator, frame, make, control, nullptr, nullptr, done);
            table.end_frame(result.counters);
        },
        progress);
    py::dict made = frame_dict(result);
    const Counters& c = result.counters;
    py::dict d = made["counters"];
    d["reused_kept"] = c.reused_kept, d["reused_fresh"] = c.reused_fresh;
    d["checked_kept"] = c.checked_kept, d["checked_fresh"] = c.checked_fresh;
    d["wrong_kept"] = c.wrong_kept, d["wrong_fresh"] = c.wrong_fresh;
    return made;
}

}  // namespace

void bind_kept_table(py::module_& m) {
    py::class_<KeptTable>(m, "KeptTable", "See viscache.AqvcTable.")
        .def(py::init([](uint64_t table_bytes, const AqvcParameters& p) {
                 return std::make_unique<KeptTable>(table_bytes, p.digest_bits, p.hash);
             }),
             py::arg("table_bytes"), py::arg("parameters"))
        .def("next_epoch", &KeptTable::next_epoch)
        .def_property_readonly("epoch", &KeptTable::epoch)
        .def_property_readonly("frames", &KeptTable::frames)
        .def_property_readonly("slots", [](const KeptTable& t) { return t.bits().slots(); })
        .def_property_readonly("occupied", [](const KeptTable& t) { return t.bits().occupied(); });
    m.def("render_aqvc_kept", &render_kept, py::arg("scene"), py::arg("caster"), py::arg("camera"),
          py::arg("integrator"), py::arg("frame"), py::arg("parameters"), py::arg("table"), py::kw_only(),
          py::arg("check") = 0.0, py::arg("repair") = false, py::arg("progress") = py::none());
}

}  // namespace viscache::bindings

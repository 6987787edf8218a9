// Oracles written in Python, and the tracer that they receive.
#include "python_oracle.h"

#include "arrays.h"
#include "viscache/scene/scene.h"

namespace viscache::bindings {

void bind_python_oracle(py::module_& m) {
    py::class_<PythonTracer, std::shared_ptr<PythonTracer>>(
        m, "PythonTracer", "Traces exact rays for an oracle written in Python.")
        .def("block", &PythonTracer::block, py::arg("eyes"), py::arg("ends"), py::arg("wanted"))
        .def("pairs", &PythonTracer::pairs, py::arg("eyes"), py::arg("index"), py::arg("ends"));
    py::class_<PythonSource, OracleSource>(m, "PythonSource", "Makes oracles from a class written in Python.")
        .def(py::init([](const Scene& scene, const RayCaster& caster, py::object written) {
                 return std::make_unique<PythonSource>(std::move(written), caster, scene.offset_extent());
             }),
             // The source refers to both without owning them: they live as long as it does.
             py::arg("scene"), py::arg("caster"), py::arg("written"), py::keep_alive<1, 2>(),
             py::keep_alive<1, 3>());
}

}  // namespace viscache::bindings

// Exact visibility by shafts.
#include <pybind11/stl.h>

#include "arrays.h"
#include "isa_argument.h"
#include "viscache/visibility/shaft_source.h"

namespace viscache::bindings {

void bind_shafts(py::module_& m) {
    py::class_<ShaftScene>(m, "ShaftScene",
                           "The triangles of a scene for shafts; the tree is built on first use.")
        .def(py::init<std::shared_ptr<const Scene>, uint64_t>(), py::arg("scene"), py::kw_only(),
             py::arg("max_bytes") = uint64_t{1} << 32)
        .def_property_readonly("refusal", &ShaftScene::refusal,
                               "Why packets answer everything; empty if shafts can be used.")
        .def(
            "memory_bytes", [](const ShaftScene& s) { return s.tree(Control{}).bytes(); },
            "Bytes of the tree, which is built if it does not exist.");
    py::class_<ShaftSource, OracleSource>(m, "ShaftSource", "See viscache.Exact.")
        .def(py::init([](const Scene& scene, const RayCaster& caster, const ShaftScene& shafts,
                         OracleSource& exact, bool choose, float bounds,
                         const std::optional<std::string>& isa) {
                 const ShaftOptions options{.choose = choose, .bounds = bounds, .isa = isa_of(isa)};
                 return std::make_unique<ShaftSource>(scene, caster, shafts, exact, options);
             }),
             py::arg("scene"), py::arg("caster"), py::arg("shafts"), py::arg("exact"), py::kw_only(),
             py::arg("choose") = false, py::arg("bounds") = 1, py::arg("isa") = py::none(),
             py::keep_alive<1, 2>(), py::keep_alive<1, 3>(), py::keep_alive<1, 4>(), py::keep_alive<1, 5>());
}

}  // namespace viscache::bindings

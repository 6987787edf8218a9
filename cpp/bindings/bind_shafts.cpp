// Exact visibility by shafts.

#include "arrays.h"
#include "caster_queries.h"
#include "isa_argument.h"
#include "real_numbers.h"
#include "viscache/shafts/shaft_matrix.h"
#include "viscache/shafts/shaft_source.h"

namespace viscache::bindings {

namespace {

py::dict work_dict(const ShaftMatrixWork& work) {
    using namespace py::literals;
    const ShaftCounts& counts = work.sums.work;
    py::dict told("shaft_queries"_a = work.sums.queries, "left_to_packets"_a = work.sums.left_to_packets,
                  "shaft_doubted"_a = counts.doubted, "shaft_long_lists"_a = counts.long_lists,
                  "shaft_asked_packets"_a = counts.asked, "shaft_traced_packets"_a = counts.packets,
                  "shaft_tree_s"_a = work.tree_s);
    if (!work.no_shafts.empty()) told["no_shafts"] = work.no_shafts;
    return told;
}

/// (bits of `visible_matrix`, what shafts did)
py::tuple shaft_bits(const ShaftScene& scene, const RayCaster& caster, const FloatArray& points,
                     const FloatArray& targets, bool choose, float bounds,
                     const std::optional<std::string>& isa, int threads, const py::object& progress) {
    // An unknown variant raises before anything is built.
    const ShaftOptions options{.choose = choose, .bounds = bounds, .isa = isa_of(isa)};
    MatrixCall call(points, targets);
    ShaftMatrixWork work = run_interruptible(
        [&](Control& control) {
            return shaft_matrix(scene, caster, call.from, call.to, call.rows, options, threads, control);
        },
        progress);
    return py::make_tuple(call.bits, work_dict(work));
}

}  // namespace

void bind_shafts(py::module_& m) {
    py::class_<ShaftScene>(m, "ShaftScene",
                           "The triangles of a scene for shafts; the tree is built on first use.")
        .def(py::init<std::shared_ptr<const Scene>, uint64_t>(), py::arg("scene"), py::kw_only(),
             py::arg("max_bytes") = uint64_t{1} << 32)
        .def_property_readonly("refusal", &ShaftScene::refusal,
                               "Why packets answer everything; empty if shafts can be used.")
        .def(
            "memory_bytes",
            [](const ShaftScene& s, int threads) {
                // The tree is built here if nobody has used it yet.
                return run_interruptible([&](Control& control) { return s.tree(threads, control).bytes(); });
            },
            py::arg("threads") = 0, "Bytes of the tree, which is built if it does not exist.");
    m.def("shaft_matrix", &shaft_bits, py::arg("scene"), py::arg("caster"), py::arg("points"),
          py::arg("targets"), py::kw_only(), py::arg("choose") = false, py::arg("bounds") = 1,
          py::arg("isa") = py::none(), py::arg("threads") = 0, py::arg("progress") = py::none(),
          "The bits of RayCaster.visible_matrix by shafts, and what they did.");
    py::class_<ShaftSource, OracleSource>(m, "ShaftSource", "See viscache.Exact.")
        .def(py::init([](const Scene&, const RayCaster& caster, const ShaftScene& shafts, OracleSource& exact,
                         bool choose, float bounds, const std::optional<std::string>& isa) {
                 const ShaftOptions options{.choose = choose, .bounds = bounds, .isa = isa_of(isa)};
                 return std::make_unique<ShaftSource>(caster, shafts, exact, options);
             }),
             py::arg("scene"), py::arg("caster"), py::arg("shafts"), py::arg("exact"), py::kw_only(),
             py::arg("choose") = false, py::arg("bounds") = 1, py::arg("isa") = py::none(),
             // Everything that the source refers to: scene, caster, shafts and the exact source
             py::keep_alive<1, 2>(), py::keep_alive<1, 3>(), py::keep_alive<1, 4>(), py::keep_alive<1, 5>());
}

}  // namespace viscache::bindings

// Our own single-ray tracers: the BSP, and the watertight one over boxes of Embree.
#include "bind_rows.h"
#include "caster_queries.h"
#include "viscache/casters/bsp_caster.h"
#include "viscache/casters/watertight_caster.h"

namespace viscache::bindings {

namespace {

constexpr size_t kStepChunk = 1024;  // rays between two checks for Ctrl-C

py::dict bsp_stats(const BspStats& s) {
    using namespace py::literals;
    return py::dict("triangles"_a = s.triangles, "degenerate"_a = s.degenerate, "nodes"_a = s.nodes,
                    "leaves"_a = s.leaves, "empty_leaves"_a = s.empty_leaves, "references"_a = s.references,
                    "max_depth"_a = s.max_depth, "depth"_a = s.depth, "bytes"_a = s.bytes);
}

std::shared_ptr<BspCaster> build(const std::shared_ptr<Scene>& scene, const BspSettings& settings,
                                 int threads) {
    return run_interruptible(
        [&](Control& control) { return std::make_shared<BspCaster>(scene, settings, threads, control); });
}

py::dict count_steps(const BspCaster& caster, const FloatArray& o, const FloatArray& d) {
    // All rays are checked and copied first, with the lock.
    const std::vector<Ray> rays = RayRows(o, d).part(0, size_t(o.shape(0)));
    BspSteps s;
    run_interruptible([&](Control& control) {
        // Chunks, so that Ctrl-C does not wait for millions of rays
        for (size_t first = 0; first < rays.size(); first += kStepChunk) {
            control.check();
            const size_t n = std::min(kStepChunk, rays.size() - first);
            const BspSteps some = caster.count_steps(std::span(rays).subspan(first, n));
            s.nodes += some.nodes;
            s.leaves += some.leaves;
            s.tests += some.tests;
        }
    });
    return py::dict(py::arg("nodes") = s.nodes, py::arg("leaves") = s.leaves, py::arg("tests") = s.tests);
}

}  // namespace

void bind_bsp(py::module_& m) {
    py::module_ v = m.def_submodule("visibility", "Ray casters and their parts.");
    py::class_<BspSettings> settings(v, "BspSettings", "Settings of the BSP; see viscache.Bsp.");
    bind_rows(settings, kBspRows);
    py::class_<BspCaster, RayCaster, std::shared_ptr<BspCaster>> caster(
        v, "BspCaster", "Traces single rays through a BSP tree.");
    caster.def(py::init(&build), py::arg("scene"), py::arg("settings"), py::kw_only(), py::arg("threads") = 0)
        .def_property_readonly("stats", [](const BspCaster& c) { return bsp_stats(c.stats()); })
        .def("count_steps", &count_steps, py::arg("origins"), py::arg("directions"),
             "Visited nodes, visited leaves and tested triangles of nearest-hit queries, summed over all "
             "rays.");
    bind_queries(caster);
    py::class_<WatertightCaster, RayCaster, std::shared_ptr<WatertightCaster>> watertight(
        v, "WatertightCaster", "Embree finds candidates, the watertight test of triangles decides.");
    watertight.def(py::init([](std::shared_ptr<Scene> scene) {
                       return std::make_shared<WatertightCaster>(std::move(scene));
                   }),
                   py::arg("scene"), py::call_guard<WithoutGil>());
    bind_queries(watertight);
}

}  // namespace viscache::bindings

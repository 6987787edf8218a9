// Surface points and their rows of visibility.
#include <pybind11/stl.h>

#include "checked_rows.h"
#include "interrupt.h"
#include "viscache/correlation/spatial_groups.h"
#include "viscache/correlation/surface_points.h"
#include "viscache/scene/check.h"
#include "viscache/visibility/ray_caster.h"
#include "viscache/visibility/visibility_rows.h"

namespace viscache::bindings {

namespace {

template <class T>
py::array_t<T> array_of(const std::vector<T>& v) {
    return py::array_t<T>(py::ssize_t(v.size()), v.data());
}

py::dict points_dict(const SurfacePoints& p) {
    py::dict d;
    d["position"] = from_vec3s(p.position), d["normal"] = from_vec3s(p.normal);
    d["shading_normal"] = from_vec3s(p.shading_normal);
    d["group"] = array_of(p.group), d["stratum"] = array_of(p.stratum);
    d["width"] = p.width, d["height"] = p.height;
    d["bad_normals"] = p.bad_normals, d["misses"] = p.misses;
    return d;
}

py::dict camera_points(const Scene& scene, const RayCaster& caster, const Camera& camera, size_t n,
                       uint64_t seed, int threads) {
    check_camera(camera);
    SurfacePoints points;
    run_interruptible([&](Control& control) {
        points = viscache::camera_points(scene, caster, camera, n, seed, threads, control);
    });
    return points_dict(points);
}

py::dict area_points(const Scene& scene, size_t n, uint64_t seed) {
    SurfacePoints points;
    run_interruptible([&](Control& control) { points = viscache::area_points(scene, n, seed, control); });
    return points_dict(points);
}

py::tuple visibility_rows(const Scene& scene, const RayCaster& caster, const FloatArray& positions,
                          const FloatArray& normals, const FloatArray& directions, float t_max,
                          std::optional<PacketOrder> order, int threads, const py::object& progress) {
    const RowInput input{usable(positions, "positions"), units(normals, "normals"),
                         units(directions, "directions"), t_max};
    if (!(t_max > 0)) throw py::value_error("t_max must be > 0, got " + std::to_string(t_max));
    if (input.normal.size() != input.position.size())
        throw py::value_error("positions and normals must have equal numbers of rows, got " +
                              shape_text(positions) + " and " + shape_text(normals));
    const size_t n = input.position.size(), words = row_words_for(input.direction.size());
    py::array_t<uint64_t> bits({n, words});
    uint64_t rays = 0;
    run_interruptible(
        [&, rows = std::span(bits.mutable_data(), n * words)](Control& control) {
            control.total = n;
            rays = viscache::visibility_rows(caster, scene.offset_extent(), input, rows, order, threads,
                                             control, &control.done);
        },
        progress);
    return py::make_tuple(bits, rays);
}

}  // namespace

void bind_correlation_rows(py::module_& m) {
    py::module_ c = m.def_submodule("correlation", "Correlation statistics of visibility.");
    c.def("camera_points", &camera_points, py::arg("scene"), py::arg("caster"), py::arg("camera"),
          py::arg("n"), py::arg("seed"), py::arg("threads") = 0,
          "Primary hits: position, normal, shading_normal (N, 3), group, stratum (N,), width, height, "
          "bad_normals, misses.");
    c.def("area_points", &area_points, py::arg("scene"), py::arg("n"), py::arg("seed"),
          "The same uniform over the area.");
    c.def(
        "spatial_groups",
        [](const FloatArray& positions) { return array_of(spatial_groups(usable(positions, "positions"))); },
        py::arg("positions"), "Sixteen compact blocks of (nearly) equal size: numbers (N,).");
    c.def("visibility_rows", &visibility_rows, py::arg("scene"), py::arg("caster"), py::arg("positions"),
          py::arg("normals"), py::arg("directions"), py::kw_only(), py::arg("t_max") = kInfinity,
          py::arg("order") = py::none(), py::arg("threads") = 0, py::arg("progress") = py::none(),
          "Rows of bits (N, words) uint64 and the number of rays.");
}

}  // namespace viscache::bindings

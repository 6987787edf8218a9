// Surface points and their rows of visibility bits.

#include "checked_rows.h"
#include "interrupt.h"
#include "isa_argument.h"
#include "oracle_arrays.h"
#include "real_numbers.h"
#include "viscache/correlation/spatial_groups.h"
#include "viscache/correlation/surface_points.h"
#include "viscache/oracles/visibility_rows.h"
#include "viscache/scene/check.h"
#include "viscache/visibility/point_rows.h"
#include "viscache/visibility/ray_caster.h"
#include "viscache/vlf/aligned_rows.h"

namespace viscache::bindings {

namespace {

py::dict points_dict(const SurfacePoints& p) {
    using namespace py::literals;
    return py::dict("position"_a = from_vec3s(p.position), "normal"_a = from_vec3s(p.normal),
                    "shading_normal"_a = from_vec3s(p.shading_normal), "group"_a = array_of(p.group),
                    "stratum"_a = array_of(p.stratum), "width"_a = p.width, "height"_a = p.height,
                    "bad_normals"_a = p.bad_normals, "misses"_a = p.misses);
}

py::dict camera_points(const Scene& scene, const RayCaster& caster, const Camera& camera, size_t n,
                       uint64_t seed, int threads) {
    check_camera(camera);
    return points_dict(run_interruptible([&](Control& control) {
        return viscache::camera_points(scene, caster, camera, n, seed, threads, control);
    }));
}

py::dict area_points(const Scene& scene, size_t n, uint64_t seed) {
    return points_dict(
        run_interruptible([&](Control& control) { return viscache::area_points(scene, n, seed, control); }));
}

/// The checked arguments of a call, and its result.
struct RowCall {
    RowInput input;
    py::array_t<uint64_t> bits;

    RowCall(const FloatArray& positions, const FloatArray& normals, size_t columns)
        : input{.position = usable(positions, "positions"),
                .normal = units(normals, "normals"),
                .direction = {}} {
        if (input.normal.size() != input.position.size())
            throw py::value_error("positions and normals must have equal numbers of rows, got " +
                                  shape_text(positions) + " and " + shape_text(normals));
        bits = py::array_t<uint64_t>({input.position.size(), row_words_for(columns)});
    }
    RowCall(const FloatArray& positions, const FloatArray& normals, const FloatArray& directions, float t_max)
        : RowCall(positions, normals, units(directions, "directions").size()) {
        input.direction = units(directions, "directions");
        input.t_max = t_max;
        if (!(t_max > 0)) throw py::value_error("t_max must be > 0, got " + std::to_string(t_max));
    }
    /// Runs work(rows, control) without the interpreter's lock.
    template <class Work>
    void run(Work work, const py::object& progress) {
        run_interruptible(
            // The pointer is taken before the lock is released.
            [&, rows = std::span(bits.mutable_data(), size_t(bits.size()))](Control& control) {
                control.total = input.position.size();
                work(rows, control);
            },
            progress);
    }
};

py::tuple visibility_rows(const Scene& scene, const RayCaster& caster, const FloatArray& positions,
                          const FloatArray& normals, const FloatArray& directions, float t_max,
                          std::optional<PacketOrder> order, int threads, const py::object& progress) {
    RowCall call(positions, normals, directions, t_max);
    uint64_t rays = 0;
    call.run(
        [&](std::span<Word> rows, Control& control) {
            rays = viscache::visibility_rows(caster, scene.offset_extent(), call.input, rows, order, threads,
                                             control, &control.done);
        },
        progress);
    return py::make_tuple(call.bits, rays);
}

/// (bits, rays, whether the batch traced them, predicted ns per ray of the batch and of Embree)
py::tuple aligned_rows(const Scene& scene, const AlignedBatch& batch, const RayCaster& caster,
                       const FloatArray& positions, const FloatArray& normals, const FloatArray& directions,
                       float t_max, bool choose, int threads, const std::optional<std::string>& isa,
                       const py::object& progress) {
    RowCall call(positions, normals, directions, t_max);
    AlignedRows found;
    AlignedWish wish{.isa = isa_of(isa)};
    // Without a wish the engine is chosen.
    if (!choose) wish.engine = AlignedEngine::kBatch;
    call.run(
        [&](std::span<Word> rows, Control& control) {
            found = viscache::aligned_rows(batch, caster, scene.offset_extent(), call.input, rows, wish,
                                           threads, control);
        },
        progress);
    const EngineChoice& c = found.choice;
    return py::make_tuple(call.bits, found.rays, c.engine == AlignedEngine::kBatch, c.batch_ns, c.embree_ns);
}

/// (bits, rays, what the engines did)
py::tuple point_rows(const Scene& scene, OracleSource& source, const FloatArray& positions,
                     const FloatArray& normals, const py::dict& ends, int threads,
                     const py::object& progress) {
    const FarEnds far = far_ends_from(ends, scene.offset_extent());
    RowCall call(positions, normals, far.count);
    PointRows found;
    call.run(
        [&](std::span<Word> rows, Control& control) {
            found =
                viscache::point_rows(source, scene.offset_extent(), call.input, far, rows, threads, control);
        },
        progress);
    py::dict engine;
    // A value is a number or a text, which pybind11 converts
    for (const auto& [name, value] : found.report.engine) engine[py::str(name)] = value;
    return py::make_tuple(call.bits, found.rays, engine);
}

}  // namespace

void bind_correlation_rows(py::module_& m) {
    py::module_ c = m.def_submodule("correlation", "Correlation statistics of visibility.");
    c.def("camera_points", &camera_points, py::arg("scene"), py::arg("caster"), py::arg("camera"),
          py::arg("n"), py::arg("seed"), py::arg("threads") = 0,
          "Primary hits: position, normal, shading_normal (N, 3), group, stratum (N,), width, height, "
          "bad_normals, misses.");
    c.def("area_points", &area_points, py::arg("scene"), py::arg("n"), py::arg("seed"),
          "Points with uniform density over the surface area; the same fields.");
    c.def(
        "spatial_groups",
        [](const FloatArray& positions) { return array_of(spatial_groups(usable(positions, "positions"))); },
        py::arg("positions"), "Group numbers (N,): sixteen compact groups of nearly equal size.");
    c.def("visibility_rows", &visibility_rows, py::arg("scene"), py::arg("caster"), py::arg("positions"),
          py::arg("normals"), py::arg("directions"), py::kw_only(), py::arg("t_max") = kInfinity,
          py::arg("order") = py::none(), py::arg("threads") = 0, py::arg("progress") = py::none(),
          "Bit rows (N, words) uint64 and the number of rays.");
    c.def("point_rows", &point_rows, py::arg("scene"), py::arg("source"), py::arg("positions"),
          py::arg("normals"), py::arg("ends"), py::kw_only(), py::arg("threads") = 0,
          py::arg("progress") = py::none(),
          "Bit rows (N, words) uint64 of far ends that are points, the number of rays, and what the engines "
          "did.");
    c.def("aligned_rows", &aligned_rows, py::arg("scene"), py::arg("batch"), py::arg("caster"),
          py::arg("positions"), py::arg("normals"), py::arg("directions"), py::kw_only(),
          py::arg("t_max") = kInfinity, py::arg("choose") = true, py::arg("threads") = 0,
          py::arg("isa") = py::none(), py::arg("progress") = py::none(),
          "The same, traced by the batch, or by the faster engine if `choose` is set. Also whether the batch "
          "traced them, and the predicted ns per ray of the batch and of Embree.");
}

}  // namespace viscache::bindings

// Parts of the visibility field, and ambient occlusion from bit rows along its directions.
#include "checked_rows.h"
#include "viscache/render/aligned_ambient.h"
#include "viscache/vlf/auto_settings.h"
#include "viscache/vlf/direction_axes.h"
#include "viscache/vlf/directions.h"
#include "viscache/vlf/tile_bsp.h"

namespace viscache::bindings {

namespace {

/// Numbers of the direction along each axis and of the one against it; -1: none.
py::array_t<int64_t> shared_axes(const FloatArray& directions) {
    const auto axes = axes_of(units(directions, "directions"));
    py::array_t<int64_t> numbers({py::ssize_t(axes.size()), py::ssize_t(2)});
    int64_t* out = numbers.mutable_data();
    for (const SharedAxis& axis : axes) {
        *out++ = axis.along;
        *out++ = axis.against == SharedAxis::kNone ? -1 : int64_t(axis.against);
    }
    return numbers;
}

}  // namespace

void bind_vlf(py::module_& t) {
    t.def("tile_depth", &tile_depth, py::arg("count"), py::arg("depth"), py::arg("leaf_target"));
    t.def(
        "expected_build_s",
        [](const std::shared_ptr<Scene>& scene, const FieldSettings& settings) {
            settings.validate();
            check_tiles(settings.n_tiles);
            const FieldTriangles triangles(scene, settings.kernel, settings.head_room);
            return expected_build_s(triangles, settings);
        },
        py::arg("scene"), py::arg("settings"), "Estimated CPU seconds of the build.");
    t.def("shared_axes", &shared_axes, py::arg("directions"),
          "Pairs of opposite unit directions (A, 2): the one along each axis and the one against it; -1: "
          "none.");
    t.def(
        "free_share",
        [](uint32_t n_directions, const FloatArray& normals, const WordArray& rows) {
            const DirectionCells cells(directions_of(n_directions));
            const size_t words = words_for(cells.count);
            const std::span<const Vec3> n(rows3(normals, "normals"), size_t(normals.shape(0)));
            if (rows.ndim() != 2 || size_t(rows.shape(0)) != n.size() || size_t(rows.shape(1)) != words)
                throw py::value_error("rows must have shape (" + std::to_string(n.size()) + ", " +
                                      std::to_string(words) + "), got " + shape_text(rows));
            py::array_t<float> out(normals.shape(0));
            for (size_t i = 0; i < n.size(); ++i)
                out.mutable_data()[i] = free_share(cells, n[i], {rows.data() + i * words, words});
            return out;
        },
        py::arg("n_directions"), py::arg("normals"), py::arg("rows"),
        "Cosine-weighted fraction of the hemisphere that is free by each bit row, (N,).");
}

}  // namespace viscache::bindings

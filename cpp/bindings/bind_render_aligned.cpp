// Ambient occlusion from bit rows along shared directions.

#include "arrays.h"
#include "real_numbers.h"
#include "viscache/render/aligned_ambient.h"
#include "viscache/vlf/directions.h"

namespace viscache::bindings {

void bind_render_aligned(py::module_& m) {
    py::module_ t = m.def_submodule("_testing");
    t.def(
        "free_share",
        [](uint32_t n_directions, const FloatArray& normals,
           const py::array_t<uint64_t, py::array::c_style | py::array::forcecast>& rows) {
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

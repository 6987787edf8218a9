// Light cells of samples, and the octahedral map of many directions.
#include "aqvc_keys.h"
#include "isa_argument.h"
#include "viscache/aqvc/light_cells.h"
#include "viscache/aqvc/octahedral_batch.h"

namespace viscache::bindings {
namespace {

/// Column of every sample, given as for `TileRun.samples`. -1: no key; -2: no free column.
py::tuple light_cells(const AqvcParameters& p, Float3 center, double radius, int semantic,
                      const FloatArray& far, const FloatArray& normal, const std::vector<float>& density,
                      uint32_t limit) {
    const auto y = vec3s(far, "far"), n = vec3s(normal, "normal");
    LocalSamples s;
    s.semantic = Semantic(semantic);
    for (size_t i = 0; i < y.size(); ++i) {
        s.add(y[i], density.at(i), density.at(i));
        if (!s.is_direction()) {
            s.normal.push_back(n.at(i));
            s.ray_end.push_back(y[i]);
        }
    }
    const CellGrid grid(p, vec3(center), radius);
    LightCells cells;
    cells.clear(limit);
    ClampCounts clamps;
    std::vector<uint32_t> column;
    cells.number(s, grid, p, column, clamps);
    return py::make_tuple(std::vector<int32_t>(column.begin(), column.end()), clamps_dict(clamps));
}

py::tuple octahedral(const FloatArray& w, const std::optional<std::string>& isa) {
    const auto d = vec3s(w, "w");
    std::vector<float> x, y, z;
    for (const Vec3& v : d) {
        x.push_back(v.x);
        y.push_back(v.y);
        z.push_back(v.z);
    }
    py::array_t<double> u(d.size()), v(d.size());
    octahedral_batch(x, y, z, {u.mutable_data(), d.size()}, {v.mutable_data(), d.size()}, isa_of(isa));
    return py::make_tuple(u, v);
}

}  // namespace

void bind_aqvc_samples(py::module_& t) {
    t.def("light_cells", &light_cells, py::arg("parameters"), py::arg("center"), py::arg("radius"),
          py::kw_only(), py::arg("semantic"), py::arg("far"), py::arg("normal"), py::arg("density"),
          py::arg("limit") = 1u << 30,
          "Columns of samples by light cell, and counts of clamped resolutions.");
    t.def("octahedral_batch", &octahedral, py::arg("w"), py::kw_only(), py::arg("isa") = py::none(),
          "Octahedral map of many directions, computed with one instruction set.");
}

}  // namespace viscache::bindings

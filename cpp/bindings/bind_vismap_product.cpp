// The pyramid of the environment, and points of the square, for product importance sampling.
#include "arrays.h"
#include "viscache/vismap/product_tree.h"

namespace viscache::bindings {

namespace {

/// The points that a pass of a pixel takes, for tests of warps and estimators.
py::array_t<double> points(PointSet set, py::ssize_t count, uint64_t seed, uint64_t pixel, uint64_t pass) {
    if (count < 0) throw py::value_error("count must be >= 0, got " + std::to_string(count));
    const PointStream stream(set, seed, Purpose::kProduct, pixel, pass);
    py::array_t<double> out({count, py::ssize_t(2)});
    for (py::ssize_t i = 0; i < count; ++i) {
        const Point2 p = stream.at(uint32_t(i));
        out.mutable_at(i, 0) = p.x;
        out.mutable_at(i, 1) = p.y;
    }
    return out;
}

void bind_pyramid(py::module_& s) {
    py::class_<EnvironmentPyramid, std::shared_ptr<EnvironmentPyramid>>(
        s, "EnvironmentPyramid", "Sums of luminance × solid angle over the equal-area map.")
        .def(py::init([](const FloatArray& pixels) {
                 if (pixels.ndim() != 3 || pixels.shape(0) != pixels.shape(1) || pixels.shape(2) != 3)
                     throw py::value_error("pixels must have shape (N, N, 3), got " + shape_text(pixels));
                 // Read in place; the pyramid copies what it keeps.
                 return EnvironmentPyramid(
                     {reinterpret_cast<const Rgb*>(pixels.data()), size_t(pixels.shape(0) * pixels.shape(1))},
                     int(pixels.shape(0)));
             }),
             py::arg("pixels"), "From N × N texels of the map in rows; N is a power of two.")
        .def_property_readonly("levels", &EnvironmentPyramid::levels)
        .def_property_readonly("total", &EnvironmentPyramid::total, "Integral of luminance over the sphere.")
        .def(
            "sums",
            [](const EnvironmentPyramid& p, int level) {
                if (level < 0 || level > p.levels())
                    throw py::value_error("level must be in [0, " + std::to_string(p.levels()) + "], got " +
                                          std::to_string(level));
                // A copy: the array may outlive the pyramid.
                return py::array_t<double>(py::ssize_t{1} << (2 * level), p.sums(level));
            },
            py::arg("level"), "Sums over the nodes of a level along the Morton curve, (4^level,).");
}

}  // namespace

void bind_vismap_product(py::module_& m) {
    py::module_ s = m.def_submodule("vismap", "Visibility maps and product sampling of the environment.");
    bind_pyramid(s);
    s.def("points", &points, py::arg("set"), py::arg("count"), py::kw_only(), py::arg("seed") = 0,
          py::arg("pixel") = 0, py::arg("pass_") = 0,
          "Random or randomised (0, 2)-sequence points of the square, (count, 2).");
}

}  // namespace viscache::bindings

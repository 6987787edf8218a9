// Product importance sampling of the environment.

#include "real_numbers.h"
#include "rows.h"
#include "table_reflection.h"
#include "viscache/math/cpu_time.h"
#include "viscache/vismap/product_tree.h"

namespace viscache::bindings {

namespace {

using Pyramid = std::shared_ptr<const EnvironmentPyramid>;

/// A product tree that keeps its environment alive.
struct BoundTree {
    Pyramid light;
    ProductTree tree;
};

void require_map_level(int m) {
    if (m < 4 || m > 7) throw py::value_error("map_level must be in [4, 7], got " + std::to_string(m));
}

std::unique_ptr<BoundTree> built(const Pyramid& light, const Reflection& reflection, int m) {
    require_map_level(m);
    auto t = std::make_unique<BoundTree>();
    t->light = light;
    t->tree.build(*light, reflection, m);
    return t;
}

/// f(Morton code) for every texel, in rows.
template <class F>
py::array_t<double> texels(const BoundTree& t, int channels, F f) {
    const py::ssize_t n = py::ssize_t{1} << t.light->levels();
    py::array_t<double> out({n, n, py::ssize_t(channels)});
    double* to = out.mutable_data();
    for (uint32_t y = 0; y < uint32_t(n); ++y)
        for (uint32_t x = 0; x < uint32_t(n); ++x, to += channels) f(morton2(x, y), to);
    return channels == 1 ? py::array_t<double>(out.reshape({n, n})) : out;
}

py::tuple draw(const BoundTree& t, const DoubleArray& u) {
    require_rows(u, 2, "u");
    if (!(t.tree.total() > 0)) throw py::value_error("total must be > 0 to draw samples, got 0");
    const py::ssize_t n = u.shape(0);
    py::array_t<int64_t> texel(n);
    std::vector<Vec3> wi(static_cast<size_t>(n));
    for (py::ssize_t i = 0; i < n; ++i) {
        const double x = u.at(i, 0), y = u.at(i, 1);
        if (!(x >= 0 && x < 1 && y >= 0 && y < 1)) throw py::value_error("u must be in [0, 1)");
        const auto s = t.tree.sample({x, y});
        texel.mutable_at(i) = int64_t(gather2(s.texel >> 1)) << t.light->levels() | gather2(s.texel);
        wi[size_t(i)] = s.wi;
    }
    return py::make_tuple(texel, from_vec3s(wi));
}

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
                return py::array_t<double>(py::ssize_t{1} << (2 * level), p.sums(level));
            },
            py::arg("level"), "Sums over the nodes of a level along the Morton curve, (4^level,).");
}

void bind_tree(py::module_& t) {
    py::class_<BoundTree>(t, "ProductTree",
                          "L·B̃ over the sphere for one point. Directions are drawn from it.")
        .def_static(
            "of_surface",
            [](const std::shared_ptr<EnvironmentPyramid>& light, const ShadingPoint& sp, int m) {
                return built(light, SurfaceReflection(sp), m);
            },
            py::arg("light"), py::arg("shading"), py::arg("map_level") = 5)
        .def_static(
            "of_table",
            [](const std::shared_ptr<EnvironmentPyramid>& light, const FloatArray& b, int m) {
                return built(light, TableReflection(b), m);
            },
            py::arg("light"), py::arg("b"), py::arg("map_level") = 5,
            "From a table of B over the map, (N, N, 3).")
        .def_property_readonly(
            "total", [](const BoundTree& t) { return t.tree.total(); }, "L_ns, the integral of L·B̃.")
        .def_property_readonly("leaves", [](const BoundTree& t) { return t.tree.leaves(); })
        .def_property_readonly("dense_level", [](const BoundTree& t) { return t.tree.dense_level(); })
        .def(
            "masses",
            [](const BoundTree& t, int level) {
                if (level < 0 || level > t.tree.dense_level())
                    throw py::value_error("level must be in [0, " + std::to_string(t.tree.dense_level()) +
                                          "], got " + std::to_string(level));
                const auto m = t.tree.masses(level);
                return py::array_t<double>(py::ssize_t(m.size()), m.data());
            },
            py::arg("level"), "Integrals of L·B̃ over the nodes of a level along the Morton curve.")
        .def(
            "texel_masses",
            [](const BoundTree& t) {
                const auto m = t.tree.texel_masses();
                return texels(t, 1, [&](uint32_t z, double* to) { *to = m[z]; });
            },
            "Integrals of L·B̃ over the texels, (R, R). Divided by L_ns they are the probabilities of the "
            "texels.")
        .def(
            "b_tilde",
            [](const BoundTree& t) {
                return texels(t, 3, [&](uint32_t z, double* to) {
                    const Rgb c = t.tree.colour(z);
                    to[0] = c.x;
                    to[1] = c.y;
                    to[2] = c.z;
                });
            },
            "B̃ of the texels, (R, R, 3).")
        .def("sample", &draw, py::arg("u"),
             "Texels drawn with points (N, 2) of the square: row-major numbers (N,) and directions (N, 3).");
}

}  // namespace

void bind_vismap_product(py::module_& m) {
    py::module_ s = m.def_submodule("vismap", "Visibility maps and product sampling of the environment.");
    bind_pyramid(s);
    py::module_ t = m.def_submodule("_testing");
    bind_tree(t);
    s.def("points", &points, py::arg("set"), py::arg("count"), py::kw_only(), py::arg("seed") = 0,
          py::arg("pixel") = 0, py::arg("pass_") = 0,
          "Random or randomised (0, 2)-sequence points of the square, (count, 2).");
    t.def(
        "reflection_at_nodes",
        [](const ShadingPoint& sp, int level, uint32_t first) {
            if (level < 6 || level > 8 || first % 16 || first >= uint32_t{1} << (2 * level))
                throw py::value_error("level must be in [6, 8] and first a node, a multiple of 16");
            RgbBlock block;
            SurfaceReflection(sp).sample(level, first, block);
            std::vector<Vec3> b(16), d(16);
            for (uint32_t i = 0; i < 16; ++i) {
                b[i] = {block.r[i], block.g[i], block.b[i]};
                d[i] = node_centres(level).at(first + i);
            }
            return std::tuple(from_vec3s(d), from_vec3s(b));
        },
        py::arg("shading"), py::arg("level"), py::arg("first"),
        "Sixteen node centres (16, 3), and B = f·cos at them as the tree computes it (16, 3).");
}

}  // namespace viscache::bindings

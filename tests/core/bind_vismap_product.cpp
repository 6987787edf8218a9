// Product importance sampling of the environment, and frames with given maps.
#include "bound_maps.h"
#include "frame_maps.h"
#include "table_reflection.h"
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

void bind_vismap_product(py::module_& t) {
    bind_tree(t);
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
    t.def(
        "given_maps",
        [](const VisMapSettings& settings, const BoolArray& bits, const FloatArray& beta,
           const std::vector<BoolArray>& dilated) {
            const auto given = std::make_shared<BoundMaps>(bits, beta, dilated);
            if (!given->dilated()) throw py::value_error("dilated must be given");
            return FrameMaps{
                {{given->view.m, [given] { return [given](Vec3, Vec3, size_t) { return given->view; }; }, 0},
                 settings},
                {},
                py::tuple()};
        },
        py::arg("settings"), py::arg("maps"), py::arg("beta"), py::arg("dilated"),
        "The same blend of maps for all points.");
}

}  // namespace viscache::bindings

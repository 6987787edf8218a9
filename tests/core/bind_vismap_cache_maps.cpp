// Parts of the visibility-map cache: maps, weights and the tree of records.
#include "isa_argument.h"
#include "map_words.h"
#include "viscache/math/morton.h"
#include "viscache/vismap/map_difference.h"
#include "viscache/vismap/neighbour_list.h"
#include "viscache/vismap/record_tracer.h"
#include "viscache/vismap/temporal.h"
#include "viscache/vismap/weights.h"

namespace viscache::bindings {

namespace {

py::array_t<uint8_t> node_codes(const WordArray& bits, int m, int level) {
    const Word* map = checked_map(bits, m);
    if (level < 0 || level > m)
        throw py::value_error("level must be in [0, m], got " + std::to_string(level));
    std::vector<Word> hierarchy(hierarchy_words(m));
    build_hierarchy(m, map, hierarchy.data());
    py::array_t<uint8_t> codes(py::ssize_t(map_cells(level)));
    for (uint32_t i = 0; i < map_cells(level); ++i)
        codes.mutable_at(i) = node_code(m, map, hierarchy.data(), level, i);
    return codes;
}

py::array_t<Word> hierarchy_of(const WordArray& bits, int m) {
    py::array_t<Word> out(py::ssize_t(hierarchy_words(checked_m(m))));
    build_hierarchy(m, checked_map(bits, m), out.mutable_data());
    return out;
}

py::array_t<float> map_differences(const WordArray& a, const WordArray& b, int m,
                                   const std::optional<std::string>& isa) {
    const auto words = py::ssize_t(map_words(checked_m(m)));
    require_rows(a, words, "a");
    require_rows(b, words, "b");
    if (a.shape(0) != b.shape(0))
        throw py::value_error("a and b must have equal numbers of rows, got " + shape_text(a) + " and " +
                              shape_text(b));
    const CountDifferences count = count_differences(isa_of(isa));
    py::array_t<float> out(a.shape(0));
    for (py::ssize_t i = 0; i < a.shape(0); ++i)
        out.mutable_at(i) = map_difference(m, a.data(i, 0), b.data(i, 0), count);
    return out;
}

/// The tree of records with an interface for tests.
struct TestTree {
    KdTree tree;
    void insert(const FloatArray& positions, uint32_t first_id) {
        const std::vector<Vec3> rows = vec3s(positions, "positions");
        for (size_t i = 0; i < rows.size(); ++i) tree.insert({rows[i], {}, first_id + uint32_t(i)});
    }
    void build(const FloatArray& positions) {
        std::vector<TreePoint> points;
        for (Vec3 p : vec3s(positions, "positions")) points.push_back({p, {}, uint32_t(points.size())});
        tree.build(std::move(points));
    }
    std::vector<std::vector<uint32_t>> search(const FloatArray& positions, float radius, int m) const {
        if (m < 1 || m > NearestSet::kMost)
            throw py::value_error("m must be in [1, 64], got " + std::to_string(m));
        std::vector<std::vector<uint32_t>> all;
        for (Vec3 p : vec3s(positions, "positions")) {
            NearestSet nearest(m, radius);
            tree.search(p, [](const TreePoint&) { return true; }, nearest);
            all.emplace_back();
            for (const NearestSet::Found& f : nearest.sorted()) all.back().push_back(f.id());
        }
        return all;
    }
    /// The same with a neighbour list. Query q skips the points whose number equals q modulo 3.
    std::pair<std::vector<std::vector<uint32_t>>, uint64_t> walk(const FloatArray& positions, float radius,
                                                                 int m) {
        std::vector<std::vector<uint32_t>> all;
        const uint64_t before = around.answered();
        for (Vec3 p : vec3s(positions, "positions")) {
            NearestSet nearest(m, radius);
            const auto accept = [&](const TreePoint& t) { return t.id % 3 != all.size() % 3; };
            around.search(tree, p, accept, nearest);
            all.emplace_back();
            for (const NearestSet::Found& f : nearest.sorted()) all.back().push_back(f.id());
        }
        return {all, around.answered() - before};
    }
    NeighbourList around;
};

void bind_maps(py::module_& t) {
    t.def("gather2", py::vectorize(gather2), py::arg("v"), "The bits at even positions, packed.");
    t.def("hierarchy", &hierarchy_of, py::arg("bits"), py::arg("m"),
          "Words of the quadtree codes above a map.");
    t.def("node_codes", &node_codes, py::arg("bits"), py::arg("m"), py::arg("level"),
          "Codes of the nodes of a level, (4^level,).");
    t.def("map_differences", &map_differences, py::arg("a"), py::arg("b"), py::arg("m"),
          py::arg("isa") = py::none(), "δ of rows of maps, (N,).");
    t.def(
        "record_pattern", [](int m, uint64_t seed) { return from_vec3s(record_pattern(checked_m(m), seed)); },
        py::arg("m"), py::arg("seed"), "Directions of the cells in Z order, (4^m, 3).");
    t.def(
        "ambient_visibility",
        [](const WordArray& bits, int m, const FloatArray& pattern, Float3 normal) {
            const std::vector<Vec3> directions = vec3s(pattern, "pattern");
            if (directions.size() != map_cells(checked_m(m)))
                throw py::value_error("pattern must have 4^m rows, got " + shape_text(pattern));
            return ambient_visibility({checked_map(bits, m), map_words(m)}, directions, vec3(normal));
        },
        py::arg("bits"), py::arg("m"), py::arg("pattern"), py::arg("normal"), "A of a map.");
    t.def("wilson_lower", py::vectorize(wilson_lower), py::arg("misses"), py::arg("rays"),
          "Lower bound of the 95 % Wilson interval of misses / rays.");
}

void bind_weights(py::module_& t) {
    t.def(
        "normalized_weight",
        [](float t, float theta, float theta_max, float lambda) {
            return NormalizedWeight(theta_max, lambda)(t, theta);
        },
        py::arg("t"), py::arg("theta"), py::arg("theta_max"), py::arg("lambda_"), "ŵ.");
    t.def(
        "geometric_weight",
        [](Float3 normal, Float3 to_record, float d_max) {
            return geometric_weight(vec3(normal), vec3(to_record), length(vec3(to_record)), d_max);
        },
        py::arg("normal"), py::arg("to_record"), py::arg("d_max"), "w_g.");
    t.def(
        "normal_angle", [](Float3 a, Float3 b) { return normal_angle(vec3(a), vec3(b)); }, py::arg("a"),
        py::arg("b"), "θ of unit normals, in radians.");
}

void bind_kd_tree(py::module_& t) {
    py::class_<TestTree>(t, "KdTree", "Tree of records. It finds the m nearest within a radius.")
        .def(py::init<>())
        .def("insert", &TestTree::insert, py::arg("positions"), py::arg("first_id"))
        .def("build", &TestTree::build, py::arg("positions"))
        .def("search", &TestTree::search, py::arg("positions"), py::arg("radius"), py::arg("m"),
             "Ids of every position, nearest first.")
        .def("walk", &TestTree::walk, py::arg("positions"), py::arg("radius"), py::arg("m"),
             "The same with a neighbour list. Query q skips ids congruent to q modulo 3. Also the number of "
             "queries that the list answered without the tree.")
        .def_property_readonly("rebuilds", [](const TestTree& t) { return t.tree.rebuilds(); })
        .def_property_readonly("depth", [](const TestTree& t) { return t.tree.depth(); })
        .def_property_readonly("oversized_leaves",
                               [](const TestTree& t) { return t.tree.oversized_leaves(); })
        .def("__len__", [](const TestTree& t) { return t.tree.size(); });
}

}  // namespace

void bind_vismap_cache_maps(py::module_& t) {
    bind_maps(t);
    bind_weights(t);
    bind_kd_tree(t);
}

}  // namespace viscache::bindings

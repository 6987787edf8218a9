// The visibility field.
#include "bind_rows.h"
#include "caster_queries.h"
#include "viscache/vlf/visibility_field.h"

namespace viscache::bindings {

namespace {

py::dict field_stats(const FieldStats& s) {
    using namespace py::literals;
    return py::dict("triangles"_a = s.triangles, "degenerate"_a = s.degenerate, "subfields"_a = s.subfields,
                    "built"_a = s.built, "evicted"_a = s.evicted, "tiles"_a = s.tiles,
                    "empty_tiles"_a = s.empty_tiles, "leaves"_a = s.leaves, "references"_a = s.references,
                    "bytes"_a = s.bytes);
}

std::shared_ptr<VisibilityField> field_over(const std::shared_ptr<Scene>& scene,
                                            const FieldSettings& settings, int threads,
                                            const py::object& progress) {
    return run_interruptible(
        [&](Control& control) {
            return std::make_shared<VisibilityField>(scene, settings, threads, control);
        },
        progress);
}

uint32_t checked_direction(const VisibilityField& field, uint32_t direction) {
    if (direction >= field.directions().size())
        throw py::value_error("direction must be < " + std::to_string(field.directions().size()) + ", got " +
                              std::to_string(direction));
    return direction;
}

/// The lists of one direction: leaves and depth range of every tile, triangles and border of every leaf.
py::dict subfield_dict(const VisibilityField& field, uint32_t direction) {
    // Keeps the subfield while its lists are copied.
    const SubfieldLease f = field.subfield(checked_direction(field, direction));
    // Compressed rows, twice: tile i has the leaves first_leaf[i] ... first_leaf[i + 1], and leaf k has the
    // triangles ids[first_id[k]] ... ids[first_id[k + 1]].
    std::vector<uint32_t> first_leaf{0}, first_id{0}, ids;
    std::vector<float> ranges, borders;
    for (size_t tile = 0; tile < f->tiles(); ++tile) {
        const TileBsp bsp = f->bsp(tile);
        for (int l = 0; l < bsp.leaves; ++l) {
            const auto leaf = f->leaf(tile, l);
            ids.insert(ids.end(), leaf.begin(), leaf.end());
            first_id.push_back(uint32_t(ids.size()));
            borders.push_back(bsp.border(l));
        }
        first_leaf.push_back(uint32_t(first_id.size() - 1));
        ranges.insert(ranges.end(), {bsp.z0, bsp.z1});
    }
    return py::dict(
        py::arg("first_leaf") = array_of(first_leaf), py::arg("first_id") = array_of(first_id),
        py::arg("ids") = array_of(ids),
        py::arg("ranges") = py::array_t<float>({py::ssize_t(f->tiles()), py::ssize_t(2)}, ranges.data()),
        py::arg("borders") = array_of(borders));
}

/// Nearest hits and any hits through given axes, and the counts of their steps.
py::tuple trace_by(const VisibilityField& field, const FloatArray& o, const FloatArray& d,
                   const UintArray& directions, const py::object& t_min, const py::object& t_max) {
    const RayRows given(o, d);
    require_same_rows(o, directions, "origins and axes");
    const size_t n = given.n;
    const FloatArray near = distances(t_min, n), far = distances(t_max, n);
    py::array_t<float> t{py::ssize_t(n)};
    py::array_t<int64_t> triangle{py::ssize_t(n)};
    py::array_t<bool> any{py::ssize_t(n)};
    FieldSteps nearest_steps, any_steps;
    // For tests of many rays through many axes: one thread, and steps counted.
    for (size_t i = 0; i < n; ++i) {
        const uint32_t axis = checked_direction(field, directions.at(py::ssize_t(i)));
        const Ray ray{given.origins[i], near.data()[near.ndim() ? i : 0], given.directions[i],
                      far.data()[far.ndim() ? i : 0]};
        const Hit hit = field.nearest(ray, axis, &nearest_steps);
        t.mutable_data()[i] = hit.t;
        triangle.mutable_data()[i] =
            hit.valid() ? int64_t(field.scene().first_triangle(hit.mesh) + hit.triangle) : -1;
        any.mutable_data()[i] = field.any(ray, axis, &any_steps);
    }
    const auto steps = [](const FieldSteps& s) {
        return py::dict(py::arg("tiles") = s.tiles, py::arg("leaves") = s.leaves, py::arg("tests") = s.tests);
    };
    return py::make_tuple(t, triangle, any, steps(nearest_steps), steps(any_steps));
}

}  // namespace

void bind_vlf_field(py::module_& m) {
    py::module_ v = m.def_submodule("vlf");
    py::class_<FieldSettings> settings(v, "FieldSettings", "Settings of the field; see viscache.Vlf.");
    bind_rows(settings, kFieldRows);
    py::class_<VisibilityField, RayCaster, std::shared_ptr<VisibilityField>> field(
        v, "VisibilityField", "Answers rays by look-up.");
    field
        .def(py::init(&field_over), py::arg("scene"), py::arg("settings"), py::kw_only(),
             py::arg("threads") = 0, py::arg("progress") = py::none())
        .def_property_readonly("settings", &VisibilityField::settings)
        .def_property_readonly("stats", [](const VisibilityField& f) { return field_stats(f.stats()); })
        .def("subfield", &subfield_dict, py::arg("direction"), "The lists of one direction as arrays.")
        .def("trace_by", &trace_by, py::arg("origins"), py::arg("directions"), py::arg("axes"),
             py::arg("t_min") = 0.f, py::arg("t_max") = kInfinity,
             "Traces every ray through a given subfield: t, triangle (N,), any (N,), steps of both kinds.");
    bind_queries(field);
}

}  // namespace viscache::bindings

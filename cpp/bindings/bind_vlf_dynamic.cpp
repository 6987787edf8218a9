// A visibility field with moving objects.
#include <pybind11/native_enum.h>

#include "caster_queries.h"
#include "real_numbers.h"
#include "viscache/vlf/dynamic.h"

namespace viscache::bindings {

namespace {

using Pairs = std::vector<std::pair<uint32_t, uint32_t>>;

std::shared_ptr<DynamicField> dynamic_field(const std::shared_ptr<Scene>& scene,
                                            const FieldSettings& settings, UpdateMode mode, int threads,
                                            const py::object& progress) {
    return run_interruptible(
        [&](Control& control) {
            return std::make_shared<DynamicField>(scene, settings, mode, threads, control);
        },
        progress);
}

uint32_t insert_object(DynamicField& field, const FloatArray& vertices, const UintArray& triangles,
                       int threads) {
    // Checked before the core takes them: coordinates and indices
    require_usable(vertices, "vertices");
    require_rows(triangles, 3, "triangles");
    const std::vector<Vec3> points = vec3s(vertices, "vertices");
    std::vector<FlatTriangle> list;
    for (py::ssize_t i = 0; i < triangles.shape(0); ++i) {
        Vec3 corner[3];
        for (py::ssize_t k = 0; k < 3; ++k) {
            const uint32_t v = triangles.at(i, k);
            if (v >= points.size())
                throw py::value_error("triangles must index vertices, row " + std::to_string(i) + " has " +
                                      std::to_string(v) + " of " + std::to_string(points.size()));
            corner[k] = points[v];
        }
        list.push_back({corner[0], corner[1], corner[2]});
    }
    // From here on without the lock: the lists of all directions change.
    const WithoutGil release;
    return field.insert(std::move(list), threads);
}

py::tuple intersect(const DynamicField& field, const FloatArray& o, const FloatArray& d, int threads) {
    const RayRows rays(o, d);
    const size_t n = rays.n;
    py::array_t<float> t{py::ssize_t(n)}, uv({py::ssize_t(n), py::ssize_t(2)});
    py::array_t<int64_t> object{py::ssize_t(n)}, triangle{py::ssize_t(n)};
    // Pointers first, then the call without the lock
    float *t_out = t.mutable_data(), *uv_out = uv.mutable_data();
    int64_t *object_out = object.mutable_data(), *triangle_out = triangle.mutable_data();
    in_chunks(n, threads, [&](size_t first, size_t last, int) {
        for (size_t i = first; i < last; ++i) {
            const DynamicHit h = field.nearest(rays[i]);
            const bool hit = h.object != DynamicHit::kNothing;
            const float nan = std::numeric_limits<float>::quiet_NaN();
            // No hit: t is infinite, there is no triangle and no barycentric coordinate.
            t_out[i] = h.t;
            object_out[i] = h.object;
            triangle_out[i] = hit ? int64_t(h.triangle) : -1;
            uv_out[2 * i] = hit ? h.u : nan;
            uv_out[2 * i + 1] = hit ? h.v : nan;
        }
    });
    return py::make_tuple(t, object, triangle, uv);
}

py::array_t<bool> dynamic_occluded(const DynamicField& field, const FloatArray& o, const FloatArray& d,
                                   const py::object& t_max, int threads) {
    const RayRows rays(o, d);
    const size_t n = rays.n;
    const FloatArray t = distances(t_max, n);
    py::array_t<bool> result{py::ssize_t(n)};
    bool* out = result.mutable_data();
    in_chunks(n, threads,
              // One distance for all rays has stride 0.
              [&, ends = t.data(), stride = size_t(t.ndim() == 1)](size_t first, size_t last, int) {
                  for (size_t i = first; i < last; ++i)
                      out[i] = field.any({rays.origins[i], 0, rays.directions[i], ends[i * stride]});
              });
    return result;
}

py::array_t<uint32_t> rows_of_pairs(const Pairs& pairs) {
    py::array_t<uint32_t> rows({py::ssize_t(pairs.size()), py::ssize_t(2)});
    uint32_t* out = rows.mutable_data();
    for (const auto& [tile, id] : pairs) {
        *out++ = tile;
        *out++ = id;
    }
    return rows;
}

uint32_t checked(const DynamicField& field, uint32_t direction) {
    if (direction >= field.settings().n_directions)
        throw py::value_error("direction must be < " + std::to_string(field.settings().n_directions) +
                              ", got " + std::to_string(direction));
    return direction;
}

}  // namespace

void bind_vlf_dynamic(py::module_& m) {
    py::module_ v = m.def_submodule("vlf");
    py::native_enum<UpdateMode>(v, "UpdateMode", "enum.Enum", "How objects are inserted into a field.")
        .value("OVERLAY", UpdateMode::kOverlay)
        .value("IN_PLACE", UpdateMode::kInPlace)
        .finalize();
    py::class_<DynamicField, std::shared_ptr<DynamicField>>(v, "DynamicField",
                                                            "A visibility field over moving objects.")
        .def(py::init(&dynamic_field), py::arg("scene"), py::arg("settings"), py::arg("mode"), py::kw_only(),
             py::arg("threads") = 0, py::arg("progress") = py::none())
        .def("insert", &insert_object, py::arg("vertices"), py::arg("triangles"), py::arg("threads") = 0)
        .def("remove", &DynamicField::remove, py::arg("object"), py::arg("threads") = 0,
             py::call_guard<WithoutGil>())
        .def(
            "transform",
            [](DynamicField& field, uint32_t object, const std::array<std::array<double, 4>, 3>& place,
               int threads) {
                // The matrix is already C++: nothing of Python is touched.
                const WithoutGil release;
                field.transform(object, {place}, threads);
            },
            py::arg("object"), py::arg("place"), py::arg("threads") = 0)
        .def("intersect", &intersect, py::arg("origins"), py::arg("directions"), py::arg("threads") = 0,
             "t, object, triangle (N,), barycentrics (N, 2).")
        .def("occluded", &dynamic_occluded, py::arg("origins"), py::arg("directions"), py::arg("t_max"),
             py::arg("threads") = 0)
        .def_property_readonly("settings", &DynamicField::settings)
        .def_property_readonly("objects", &DynamicField::objects)
        .def_property_readonly("bytes", &DynamicField::bytes)
        .def(
            "listed",
            [](const DynamicField& f, uint32_t d) { return rows_of_pairs(f.listed(checked(f, d))); },
            py::arg("direction"), "Entries (tile, triangle) of the lists of one direction.")
        .def(
            "listed_anew",
            [](const DynamicField& f, uint32_t d) { return rows_of_pairs(f.listed_anew(checked(f, d))); },
            py::arg("direction"), "The same of lists that are built from scratch.");
}

}  // namespace viscache::bindings

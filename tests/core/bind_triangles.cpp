// The triangles of a scene as one list, and intersections of single rays with single triangles.
#include "arrays.h"
#include "bind_rows.h"
#include "gil.h"
#include "viscache/casters/flat_triangles.h"
#include "viscache/casters/triangle_kernels.h"

namespace viscache::bindings {

namespace {

template <class Value>
py::array_t<int64_t> ids_of(const FlatTriangles& flat, Value value) {
    py::array_t<int64_t> a{py::ssize_t(flat.sources.size())};
    for (size_t i = 0; i < flat.sources.size(); ++i) {
        const uint32_t id = value(flat.sources[i]);
        a.mutable_data()[i] = id == kNoHit ? -1 : int64_t(id);
    }
    return a;
}

py::dict flat_dict(const Scene& scene) {
    FlatTriangles flat;
    {
        const WithoutGil release;
        flat = flat_triangles(scene);
    }
    static_assert(sizeof(FlatTriangle) == 9 * sizeof(float));
    py::array_t<float> corners({py::ssize_t(flat.triangles.size()), py::ssize_t(3), py::ssize_t(3)});
    if (!flat.triangles.empty())
        std::memcpy(corners.mutable_data(), flat.triangles.data(),
                    flat.triangles.size() * sizeof(FlatTriangle));
    py::dict d;
    d["corners"] = corners;
    d["degenerate"] = flat.degenerate;
    d["mesh"] = ids_of(flat, [](const TriangleSource& s) { return s.mesh; });
    d["triangle"] = ids_of(flat, [](const TriangleSource& s) { return s.triangle; });
    d["instance"] = ids_of(flat, [](const TriangleSource& s) { return s.instance; });
    return d;
}

/// Intersects ray i with triangle i. Rows are (t, u, v), NaN for a miss.
py::array_t<float> triangle_hits(const std::string& kernel, const FloatArray& a, const FloatArray& b,
                                 const FloatArray& c, const FloatArray& origins, const FloatArray& directions,
                                 float t_min, float t_max) {
    const Vec3 *pa = rows3(a, "a"), *pb = rows3(b, "b"), *pc = rows3(c, "c");
    const Vec3 *o = rows3(origins, "origins"), *d = rows3(directions, "directions");
    const bool wald = named<TriangleKernel>("kernel", kernel) == TriangleKernel::kWald;
    for (const FloatArray* other : {&b, &c, &origins, &directions})
        if (other->shape(0) != a.shape(0))
            throw py::value_error("all arrays must have equal numbers of rows, got " + shape_text(a) +
                                  " and " + shape_text(*other));
    py::array_t<float> rows({a.shape(0), py::ssize_t(3)});
    for (py::ssize_t i = 0; i < a.shape(0); ++i) {
        const Ray ray{o[i], t_min, d[i], t_max};
        TriangleHit hit;
        const bool found =
            wald ? intersect_wald(wald_triangle(pa[i], pb[i], pc[i], 0), ray, t_max, hit)
                 : intersect_watertight({pa[i], pb[i], pc[i], 0, {}}, ShearedRay(ray), t_max, hit);
        const float nan = std::numeric_limits<float>::quiet_NaN();
        float* row = rows.mutable_data(i, 0);
        row[0] = found ? hit.t : nan;
        row[1] = found ? hit.u : nan;
        row[2] = found ? hit.v : nan;
    }
    return rows;
}

using NumberArray = py::array_t<int64_t, py::array::c_style | py::array::forcecast>;  // of meshes, triangles

/// Whether point (u, v) of each triangle is solid by its alpha mask.
py::array_t<bool> solid(const Scene& scene, const NumberArray& meshes, const NumberArray& triangles,
                        const FloatArray& uv) {
    const py::ssize_t n = meshes.size();
    if (triangles.size() != n || uv.ndim() != 2 || uv.shape(0) != n || uv.shape(1) != 2)
        throw py::value_error("meshes and triangles must be (N,) and uv (N, 2), got " + shape_text(meshes) +
                              ", " + shape_text(triangles) + " and " + shape_text(uv));
    py::array_t<bool> out{n};
    const auto has = [](int64_t i, size_t count) { return i >= 0 && uint64_t(i) < count; };
    for (py::ssize_t i = 0; i < n; ++i) {
        const int64_t mesh = meshes.data()[i], triangle = triangles.data()[i];
        if (!has(mesh, scene.meshes().size()) ||
            !has(triangle, scene.meshes()[size_t(mesh)].triangles.size()))
            throw py::value_error("the scene has no triangle " + std::to_string(triangle) + " of mesh " +
                                  std::to_string(mesh) + ", row " + std::to_string(i));
        const float* p = uv.data() + 2 * i;
        out.mutable_data()[i] = scene.solid_at(uint32_t(mesh), uint32_t(triangle), p[0], p[1]);
    }
    return out;
}

}  // namespace

void bind_triangles(py::module_& t) {
    t.def("flat_triangles", &flat_dict, py::arg("scene"),
          "Placed triangles: corners (T, 3, 3), mesh, triangle and instance (-1: none), and the number of "
          "degenerate ones, left out.");
    t.def(
        "solid_at", &solid, py::arg("scene"), py::arg("meshes"), py::arg("triangles"), py::arg("uv"),
        "(N,) bool: whether points of triangles are solid by their alpha masks. (u, v) are the barycentrics "
        "of the second and the third corner.");
    t.def("triangle_hits", &triangle_hits, py::arg("kernel"), py::arg("a"), py::arg("b"), py::arg("c"),
          py::arg("origins"), py::arg("directions"), py::arg("t_min") = 0.f, py::arg("t_max") = kInfinity,
          "Intersects ray i with triangle (a, b, c)[i]: rows (t, u, v) with t_min < t <= t_max, NaN for a "
          "miss.");
}

}  // namespace viscache::bindings

// Scene and its exact rays.
#include <pybind11/native_enum.h>
#include <pybind11/stl.h>

#include "arrays.h"
#include "interrupt.h"
#include "viscache/visibility/block_tracer.h"
#include "viscache/visibility/check_rays.h"
#include "viscache/visibility/embree_caster.h"

namespace viscache::bindings {

namespace {

constexpr size_t kChunk = 1 << 13;
constexpr size_t kQuick = 1 << 18;      // calls of fewer rays end before anyone could press Ctrl-C
constexpr size_t kSortChunk = 1 << 16;  // sorting gains with the size of a chunk

void require_usable(const FloatArray& a, const char* name) {
    const Vec3* rows = rows3(a, name);
    if (const auto i = first_unusable({rows, size_t(a.shape(0))}))
        throw py::value_error(std::string(name) + " must be finite and at most 1e16 in size, row " +
                              std::to_string(*i) + " is (" + std::to_string(rows[*i].x) + ", " +
                              std::to_string(rows[*i].y) + ", " + std::to_string(rows[*i].z) + ")");
}

void require_same_rows(const py::array& a, const py::array& b, const char* names) {
    if (a.shape(0) != b.shape(0))
        throw py::value_error(std::string(names) + " must have equal numbers of rows, got " + shape_text(a) +
                              " and " + shape_text(b));
}

/// t_max: one number for all rays, or one per ray; never NaN.
FloatArray distances(const py::object& t_max, size_t n) {
    auto a = FloatArray::ensure(t_max);
    if (!a) PyErr_Clear();
    if (!a || a.ndim() > 1 || (a.ndim() == 1 && size_t(a.shape(0)) != n))
        throw py::value_error("t_max must be a number or have shape (" + std::to_string(n) + ",)");
    for (py::ssize_t i = 0; i < a.size(); ++i)
        if (!(a.data()[i] >= 0))
            throw py::value_error("t_max must be >= 0, got " + std::to_string(a.data()[i]));
    return a;
}

/// A ray without direction has nowhere to go: it is empty.
Ray endless(Vec3 origin, Vec3 direction) {
    return {origin, 0, direction, direction == Vec3{} ? 0.f : kInfinity};
}

/// Calls work(first, last, worker) for chunks of [0, n); small calls start no threads they cannot use.
template <class Work>
void in_chunks(size_t n, int threads, Work work, size_t size = kChunk) {
    const auto chunk = [&](size_t c, int worker) { work(c * size, std::min(n, (c + 1) * size), worker); };
    const size_t chunks = (n + size - 1) / size;
    if (n < kQuick) {
        py::gil_scoped_release release;
        parallel_for(chunks, threads, chunk);
    } else {
        run_interruptible([&](Control& control) {
            parallel_for(chunks, threads, [&](size_t c, int worker) {
                control.check();
                chunk(c, worker);
            });
        });
    }
}

py::array_t<bool> occluded(const EmbreeCaster& caster, const FloatArray& o, const FloatArray& d,
                           const py::object& t_max, int threads) {
    const Vec3 *origins = rows3(o, "origins"), *directions = rows3(d, "directions");
    require_same_rows(o, d, "origins and directions");
    const size_t n = size_t(o.shape(0));
    const FloatArray t = distances(t_max, n);
    const RayArrays rays{origins, directions, t.data(), size_t(t.ndim() == 1)};
    py::array_t<bool> result{py::ssize_t(n)};
    auto* out = reinterpret_cast<uint8_t*>(result.mutable_data());
    threads = resolve_threads(threads);
    std::vector<BlockTracer> tracers(size_t(threads), BlockTracer(caster, rays, out));
    std::atomic<bool> usable{true};
    // Several chunks a thread, so that the first ones can teach the rest
    const size_t chunk = std::clamp(n / (6 * size_t(threads)), kChunk, kSortChunk);
    in_chunks(
        n, threads,
        [&](size_t first, size_t last, int worker) {
            // Checked chunk by chunk, while the rays are in the cache
            if (!all_usable({origins + first, last - first}) ||
                !all_usable({directions + first, last - first}))
                usable = false;
            else
                tracers[size_t(worker)].block(first, last - first);
        },
        chunk);
    if (!usable) require_usable(o, "origins"), require_usable(d, "directions");
    return result;
}

py::array_t<bool> visible(const EmbreeCaster& caster, const FloatArray& xs, const FloatArray& ys,
                          int threads) {
    require_usable(xs, "x"), require_usable(ys, "y");
    require_same_rows(xs, ys, "x and y");
    const Vec3 *x = rows3(xs, "x"), *y = rows3(ys, "y");
    const size_t n = size_t(xs.shape(0));
    py::array_t<bool> result{py::ssize_t(n)};
    bool* out = result.mutable_data();
    in_chunks(n, threads, [&](size_t first, size_t last, int) {
        std::vector<Ray> rays(last - first);
        std::vector<uint8_t> blocked(last - first);
        for (size_t i = first; i < last; ++i) {
            const float e = std::min(segment_epsilon(x[i], y[i]), 1.f);
            rays[i - first] = {x[i], e, y[i] - x[i], 1 - e};
        }
        caster.occluded(rays, blocked);
        for (size_t i = first; i < last; ++i) out[i] = !blocked[i - first];
    });
    return result;
}

py::tuple intersect(const EmbreeCaster& caster, const FloatArray& o, const FloatArray& d, int threads) {
    require_usable(o, "origins"), require_usable(d, "directions");
    require_same_rows(o, d, "origins and directions");
    const size_t n = size_t(o.shape(0));
    const Vec3 *origins = rows3(o, "origins"), *directions = rows3(d, "directions");
    py::array_t<float> t{py::ssize_t(n)}, uv({py::ssize_t(n), py::ssize_t(2)});
    py::array_t<int64_t> triangle{py::ssize_t(n)}, instance{py::ssize_t(n)};
    float *t_out = t.mutable_data(), *uv_out = uv.mutable_data();
    int64_t *triangle_out = triangle.mutable_data(), *instance_out = instance.mutable_data();
    run_interruptible([&](Control& control) {
        parallel_for((n + kChunk - 1) / kChunk, threads, [&](size_t chunk, int) {
            control.check();
            const size_t first = chunk * kChunk, last = std::min(n, first + kChunk);
            std::vector<Ray> rays(last - first);
            std::vector<Hit> hits(last - first);
            for (size_t i = first; i < last; ++i) rays[i - first] = endless(origins[i], directions[i]);
            caster.intersect(rays, hits);
            for (size_t i = first; i < last; ++i) {
                const Hit& h = hits[i - first];
                const float nan = std::numeric_limits<float>::quiet_NaN();
                t_out[i] = h.t;
                triangle_out[i] =
                    h.valid() ? int64_t(caster.scene().first_triangle(h.mesh) + h.triangle) : -1;
                instance_out[i] = h.valid() && h.instance != kNoHit ? int64_t(h.instance) : -1;
                uv_out[2 * i] = h.valid() ? h.u : nan, uv_out[2 * i + 1] = h.valid() ? h.v : nan;
            }
        });
    });
    return py::make_tuple(t, triangle, uv, instance);
}

/// One plan for all rays: the bare loop.
py::array_t<bool> bare_occluded(const EmbreeCaster& caster, const FloatArray& o, const FloatArray& d,
                                float t_max, int width, bool coherent, int threads) {
    require_usable(o, "origins"), require_usable(d, "directions");
    require_same_rows(o, d, "origins and directions");
    if (!(t_max >= 0)) throw py::value_error("t_max must be >= 0, got " + std::to_string(t_max));
    const size_t n = size_t(o.shape(0));
    const RayArrays rays{rows3(o, "origins"), rows3(d, "directions"), &t_max, 0};
    const PacketPlan plan{width, coherent ? Coherence::kCoherent : Coherence::kIncoherent};
    py::array_t<bool> result{py::ssize_t(n)};
    auto* out = reinterpret_cast<uint8_t*>(result.mutable_data());
    py::gil_scoped_release release;
    parallel_for((n + kChunk - 1) / kChunk, threads, [&](size_t chunk, int) {
        const size_t first = chunk * kChunk, last = std::min(n, first + kChunk);
        caster.occluded(rays, first, last - first, out, plan);
    });
    return result;
}

}  // namespace

void bind_scene(py::module_& m) {
    py::class_<Scene, std::shared_ptr<Scene>>(m, "Scene", "An immutable scene.")
        .def_static(
            "freeze",
            [](const SceneDescription& d, int threads) {
                SceneDescription copy = d;
                const py::gil_scoped_release release;
                return std::const_pointer_cast<Scene>(Scene::freeze(std::move(copy), threads));
            },
            py::arg("description"), py::arg("threads") = 0, "Validate and freeze a description.")
        .def_property_readonly("name", [](const Scene& s) { return s.description().name; })
        .def_property_readonly("triangles", &Scene::placed_triangles)
        .def_property_readonly("unique_triangles", &Scene::unique_triangles)
        .def_property_readonly("instances", [](const Scene& s) { return s.description().instances.size(); })
        .def_property_readonly("memory_bytes", &Scene::memory_bytes)
        .def_property_readonly("radius", &Scene::radius)
        .def_property_readonly("center", [](const Scene& s) { return array3(s.center()); })
        .def_property_readonly("offset_extent", &Scene::offset_extent)
        .def_property_readonly(
            "bounds", [](const Scene& s) { return std::pair(array3(s.bounds().lo), array3(s.bounds().hi)); });
    py::class_<EmbreeCaster, std::shared_ptr<EmbreeCaster>>(m, "EmbreeCaster", "Exact rays by Embree.")
        .def(py::init([](std::shared_ptr<Scene> scene, bool robust) {
                 return std::make_shared<EmbreeCaster>(std::move(scene), EmbreeOptions{robust});
             }),
             py::arg("scene"), py::kw_only(), py::arg("robust") = true,
             py::call_guard<py::gil_scoped_release>())
        .def("occluded", &occluded, py::arg("origins"), py::arg("directions"), py::arg("t_max"),
             py::arg("threads") = 0)
        .def("visible", &visible, py::arg("x"), py::arg("y"), py::arg("threads") = 0)
        .def("intersect", &intersect, py::arg("origins"), py::arg("directions"), py::arg("threads") = 0)
        .def("bare_occluded", &bare_occluded, py::arg("origins"), py::arg("directions"), py::arg("t_max"),
             py::arg("width"), py::kw_only(), py::arg("coherent") = false, py::arg("threads") = 0,
             "Baseline of `viscache bench rays`: a loop over one packet width; checks nothing.")
        .def_property_readonly("native16", &EmbreeCaster::native16);
    m.def("embree_version", &EmbreeCaster::version);
}

}  // namespace viscache::bindings

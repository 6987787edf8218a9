// Scene and its exact rays.
#include <pybind11/native_enum.h>

#include "caster_queries.h"
#include "real_numbers.h"
#include "viscache/casters/block_tracer.h"
#include "viscache/casters/embree_caster.h"

namespace viscache::bindings {

namespace {

std::optional<RayWay> ray_way(const std::optional<std::string>& name) {
    if (!name) return std::nullopt;
    if (*name == "coherent") return RayWay::kCoherent;
    if (*name == "as_given") return RayWay::kAsGiven;
    if (*name == "sorted") return RayWay::kSorted;
    throw py::value_error("way must be coherent, as_given or sorted, got " + *name);
}

/// Any hits by Embree; every block is traced in the way that suits it.
py::array_t<bool> embree_occluded(const EmbreeCaster& caster, const AnyFloatArray& o, const AnyFloatArray& d,
                                  const py::object& t_max, int threads,
                                  const std::optional<std::string>& way) {
    // Views of the arrays in any layout: a million rays are not copied before they are traced.
    const RowView origins(o, "origins"), directions(d, "directions");
    require_same_rows(o, d, "origins and directions");
    const size_t n = size_t(o.shape(0));
    const FloatArray t = distances_of_shape(t_max, n);
    // One distance for all rays is checked here; those of an array are checked with their rays.
    if (t.ndim() == 0) require_distances(t);
    const RayArrays rays{origins.rows, directions.rows, t.data(), size_t(t.ndim() == 1)};
    py::array_t<bool> result{py::ssize_t(n)};
    auto* out = reinterpret_cast<uint8_t*>(result.mutable_data());
    const std::optional<RayWay> fixed = ray_way(way);
    // Bad rays are noticed while they are traced, and need no pass of their own before.
    bool usable = true;
    const auto trace = [&](Control& control) {
        usable = trace_any_hits(caster, rays, n, out, threads, control, fixed);
    };
    // Quick calls need no second thread that looks for Ctrl-C.
    if (n < kQuick) {
        const WithoutGil release;
        Control control;
        trace(control);
    } else {
        run_interruptible(trace);
    }
    // Only now the bad row is looked for, so that the error can name it.
    if (!usable) {
        require_distances(t);
        require_usable(origins.rows, n, "origins");
        require_usable(directions.rows, n, "directions");
        throw std::runtime_error("the rays changed while they were traced");
    }
    return result;
}

/// One fixed way for all rays, without any choice.
py::array_t<bool> bare_occluded(const EmbreeCaster& caster, const FloatArray& o, const FloatArray& d,
                                float t_max, int width, bool coherent, int threads) {
    const size_t n = RayRows(o, d).n;
    if (!(t_max >= 0)) throw py::value_error("t_max must be >= 0, got " + std::to_string(t_max));
    const RayArrays rays{{o.data()}, {d.data()}, &t_max, 0};
    const PacketPlan plan{width, coherent ? Coherence::kCoherent : Coherence::kIncoherent};
    py::array_t<bool> result{py::ssize_t(n)};
    auto* out = reinterpret_cast<uint8_t*>(result.mutable_data());
    const WithoutGil release;
    parallel_for((n + kChunk - 1) / kChunk, threads, [&](size_t chunk, int) {
        const size_t first = chunk * kChunk, last = std::min(n, first + kChunk);
        caster.occluded_in_a_loop(rays, first, last - first, out, plan);
    });
    return result;
}

/// One call of Embree per ray. Gives distances only.
py::array_t<float> bare_intersect(const EmbreeCaster& caster, const FloatArray& o, const FloatArray& d,
                                  int threads) {
    const RayRows given(o, d);
    py::array_t<float> result{py::ssize_t(given.n)};
    float* out = result.mutable_data();
    // In chunks, as all callers of Embree get their rays, but one call per ray
    in_chunks(given.n, threads, [&](size_t first, size_t last, int) {
        std::vector<Hit> hits(last - first);
        caster.intersect_singly(given.part(first, last), hits);
        for (size_t i = first; i < last; ++i) out[i] = hits[i - first].t;
    });
    return result;
}

}  // namespace

void bind_scene(py::module_& m) {
    py::class_<Scene, std::shared_ptr<Scene>>(m, "Scene", "An immutable scene.")
        .def_static(
            "freeze",
            [](SceneDescription& d, int threads, bool take) {
                // Taken, the arrays move into the scene; otherwise both exist.
                SceneDescription given = take ? std::exchange(d, {}) : d;
                const WithoutGil release;
                // Python knows no constants; none of the bound methods changes a scene.
                return std::const_pointer_cast<Scene>(Scene::freeze(std::move(given), threads));
            },
            py::arg("description"), py::arg("threads") = 0, py::arg("take") = false,
            "Validate and freeze a description. `take` leaves it empty, without a copy.")
        .def_property_readonly("name", [](const Scene& s) { return s.description().name; })
        .def_property_readonly("origin", [](const Scene& s) { return s.description().origin; })
        .def_property_readonly("triangles", &Scene::placed_triangles)
        .def_property_readonly("unique_triangles", &Scene::unique_triangles)
        .def_property_readonly("instances", [](const Scene& s) { return s.description().instances.size(); })
        .def_property_readonly("memory_bytes", &Scene::memory_bytes)
        .def_property_readonly("radius", &Scene::radius)
        .def_property_readonly("center", [](const Scene& s) { return array3(s.center()); })
        .def_property_readonly("offset_extent", &Scene::offset_extent)
        .def_property_readonly(
            "bounds", [](const Scene& s) { return std::pair(array3(s.bounds().lo), array3(s.bounds().hi)); });
    py::class_<RayCaster, std::shared_ptr<RayCaster>>(m, "RayCaster", "Which rays hit, and where?");
    py::class_<EmbreeCaster, RayCaster, std::shared_ptr<EmbreeCaster>> embree(m, "EmbreeCaster",
                                                                              "Exact rays by Embree.");
    embree
        .def(py::init([](std::shared_ptr<Scene> scene, bool robust) {
                 return std::make_shared<EmbreeCaster>(std::move(scene), EmbreeOptions{robust});
             }),
             py::arg("scene"), py::kw_only(), py::arg("robust") = true, py::call_guard<WithoutGil>())
        .def("occluded", &embree_occluded, py::arg("origins"), py::arg("directions"), py::arg("t_max"),
             py::arg("threads") = 0, py::kw_only(), py::arg("way") = py::none(),
             "Any hits. `way` (coherent, as_given or sorted) fixes what otherwise follows from the rays.")
        .def("intersect", &nearest_hits<EmbreeCaster>, py::arg("origins"), py::arg("directions"),
             py::arg("threads") = 0)
        .def("bare_occluded", &bare_occluded, py::arg("origins"), py::arg("directions"), py::arg("t_max"),
             py::arg("width"), py::kw_only(), py::arg("coherent") = false, py::arg("threads") = 0,
             "Baseline of `viscache bench rays`: a loop with one packet width and no checks.")
        .def("bare_intersect", &bare_intersect, py::arg("origins"), py::arg("directions"), py::kw_only(),
             py::arg("threads") = 0,
             "Distances of nearest hits by one call of Embree per ray: the baseline of single-ray tracers.")
        .def_property_readonly("native16", &EmbreeCaster::native16);
    // Defined for all casters alike
    bind_segments(embree);
    m.def("embree_version", &EmbreeCaster::version);
}

}  // namespace viscache::bindings

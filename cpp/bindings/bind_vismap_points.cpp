// Query points of a visibility-map cache: from arrays, or the first hits of a camera's pixels.

#include "cache_points.h"
#include "interrupt.h"
#include "real_numbers.h"
#include "viscache/math/morton.h"
#include "viscache/scene/check.h"
#include "viscache/visibility/ray_caster.h"
#include "viscache/vismap/pixel_points.h"

namespace viscache::bindings {

namespace {

using IdArray = py::array_t<int64_t, py::array::c_style | py::array::forcecast>;

Points points_of(const FloatArray& positions, const FloatArray& normals, const FloatArray& d_max,
                 const FloatArray& footprint, size_t first_row) {
    const Vec3 *p = rows3(positions, "positions"), *n = rows3(normals, "normals");
    for (const auto& [name, size] : {std::pair{"normals", normals.shape(0)},
                                     {"d_max", d_max.ndim() == 1 ? d_max.shape(0) : -1},
                                     {"footprint", footprint.ndim() == 1 ? footprint.shape(0) : -1}})
        if (size != positions.shape(0))
            throw py::value_error(std::string(name) + " must have one row per position, " +
                                  std::to_string(positions.shape(0)));
    Points points;
    for (py::ssize_t i = 0; i < positions.shape(0); ++i) {
        points.push_back({p[i], n[i], d_max.at(i), footprint.at(i)});
        // Chunks of a larger array pass the number of their first row, so that errors name rows of the whole.
        check_point(points.back(), first_row + size_t(i));
    }
    return points;
}

/// Negative indices do not count from the end: they are mistakes of callers here.
Points taken(const Points& points, const IdArray& indices) {
    if (indices.ndim() != 1)
        throw py::value_error("indices must have shape (K,), got " + shape_text(indices));
    Points some;
    for (py::ssize_t i = 0; i < indices.shape(0); ++i) {
        const int64_t k = indices.at(i);
        if (k < 0 || k >= int64_t(points.size()))
            throw py::value_error("indices must be in [0, " + std::to_string(points.size()) + "), got " +
                                  std::to_string(k));
        some.push_back(points[size_t(k)]);
    }
    return some;
}

void check_view(const Camera& camera, int width, int height, const PixelRules& rules) {
    check_camera(camera);
    // More pixels than any frame has; the product of two ints could overflow.
    if (width < 1 || height < 1 || int64_t(width) * height > 1 << 28)
        throw py::value_error("size must be at least 1×1 and at most 2^28 pixels, got " +
                              std::to_string(width) + "×" + std::to_string(height));
    if (!(rules.reach > 0 && rules.reach <= 1e6f))
        throw py::value_error("reach must be in (0, 1e6], got " + std::to_string(rules.reach));
}

py::tuple with_counts(PixelPoints found) {
    // Points stay in C++: a class, whose arrays are copied only when they are read.
    return py::make_tuple(Points{std::move(found.points)}, found.misses, found.bad_normals);
}

/// First hits of cameras.
void bind_hits(py::module_& v) {
    v.def(
        "pixel_points",
        [](const Scene& scene, const RayCaster& caster, const Camera& camera, int width, int height,
           std::array<float, 2> at, const PixelRules& rules, int threads) {
            check_view(camera, width, height, rules);
            return with_counts(run_interruptible([&](Control& control) {
                return pixel_points(scene, caster, camera, width, height, {at[0], at[1]}, rules, threads,
                                    control);
            }));
        },
        py::arg("scene"), py::arg("caster"), py::arg("camera"), py::arg("width"), py::arg("height"),
        py::arg("at"), py::arg("rules"), py::arg("threads") = 0,
        "First hits through one position inside every pixel, row-major; misses; bad normals.");
    v.def(
        "sample_points",
        [](const Scene& scene, const RayCaster& caster, const Camera& camera, int width, int height,
           uint64_t seed, uint32_t sample, const PixelRules& rules, int threads) {
            check_view(camera, width, height, rules);
            return with_counts(run_interruptible([&](Control& control) {
                return sample_points(scene, caster, camera, width, height, seed, sample, rules, threads,
                                     control);
            }));
        },
        py::arg("scene"), py::arg("caster"), py::arg("camera"), py::arg("width"), py::arg("height"),
        py::arg("seed"), py::arg("sample"), py::arg("rules"), py::arg("threads") = 0,
        "The same through the position of the sample that `render` takes in every pixel.");
    v.def(
        "startup_points",
        [](const Scene& scene, const RayCaster& caster, const Camera& camera, int width, int height, size_t n,
           uint64_t seed, const PixelRules& rules) {
            check_view(camera, width, height, rules);
            // Each ray is one record at most; more would fill any memory
            if (n < 1 || n > 1 << 24)
                throw py::value_error("n must be in [1, 2^24], got " + std::to_string(n));
            return with_counts(run_interruptible([&](Control& control) {
                return startup_points(scene, caster, camera, width, height, n, seed, rules, control);
            }));
        },
        py::arg("scene"), py::arg("caster"), py::arg("camera"), py::arg("width"), py::arg("height"),
        py::arg("n"), py::arg("seed"), py::arg("rules"),
        "First hits of n rays stratified over the image; misses; bad normals.");
}

}  // namespace

void bind_vismap_points(py::module_& m) {
    py::module_ v = m.def_submodule("vismap");
    py::class_<Points>(v, "CachePoints", "Query points of a cache. d_max is 0 for points without a surface.")
        .def(py::init(&points_of), py::arg("positions"), py::arg("normals"), py::arg("d_max"),
             py::arg("footprint"), py::arg("first_row") = 0)
        .def("__len__", [](const Points& p) { return p.size(); })
        .def("take", &taken, py::arg("indices"), "A selection of the points, in this order.")
        .def_property_readonly(
            "positions",
            [](const Points& p) { return vectors(p.size(), [&](size_t i) { return p[i].position; }); })
        .def_property_readonly(
            "normals",
            [](const Points& p) { return vectors(p.size(), [&](size_t i) { return p[i].normal; }); })
        .def_property_readonly(
            "d_max",
            [](const Points& p) { return column<float>(p.size(), [&](size_t i) { return p[i].d_max; }); })
        .def_property_readonly("footprint", [](const Points& p) {
            return column<float>(p.size(), [&](size_t i) { return p[i].footprint; });
        });
    py::class_<PixelRules>(v, "PixelRules", "Search radii of records; see viscache.MapSettings.")
        .def(py::init([](float reach, float most_reach, float least_cos) {
                 return PixelRules{reach, most_reach, least_cos};
             }),
             py::arg("reach"), py::arg("most_reach") = PixelRules{}.most_reach,
             py::arg("least_cos") = PixelRules{}.least_cos);
    v.def(
        "morton_order",
        [](const FloatArray& positions) {
            const Vec3* rows = rows3(positions, "positions");
            const size_t n = size_t(positions.shape(0));
            // The last number stands for "no record"
            if (n >= kNoRecord) throw py::value_error("positions must be fewer than 2^32 - 1");
            std::vector<uint32_t> order;
            {
                const WithoutGil release;
                order = morton_order({rows, n});
            }
            return py::array_t<uint32_t>(py::ssize_t(n), order.data());
        },
        py::arg("positions"), "Row numbers of the positions along the Morton curve of their bounding box.");
    bind_hits(v);
}

}  // namespace viscache::bindings

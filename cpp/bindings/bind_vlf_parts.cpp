// Parts of the visibility field: tiles of triangles, tiles along rays, leaves of depth ranges; predicted
// cost.

#include "bind_rows.h"
#include "caster_queries.h"
#include "real_numbers.h"
#include "viscache/vlf/auto_settings.h"
#include "viscache/vlf/rasterize.h"
#include "viscache/vlf/tile_bsp.h"
#include "viscache/vlf/tile_walk.h"

namespace viscache::bindings {

namespace {

/// Rows (triangle, x, y), and their depth ranges.
py::tuple cover(const FloatArray& corners, int n_tiles) {
    if (corners.ndim() != 3 || corners.shape(1) != 3 || corners.shape(2) != 3)
        throw py::value_error("triangles must have shape (N, 3, 3), got " + shape_text(corners));
    check_tiles(n_tiles);
    // With the same slack as a field
    const TileGrid grid{.n = n_tiles};
    std::vector<int64_t> tiles;
    std::vector<float> depths;
    for (py::ssize_t i = 0; i < corners.shape(0); ++i) {
        ProjectedTriangle t;
        for (py::ssize_t k = 0; k < 3; ++k) {
            t.x[size_t(k)] = corners.at(i, k, 0);
            t.y[size_t(k)] = corners.at(i, k, 1);
            t.z[size_t(k)] = corners.at(i, k, 2);
        }
        cover_tiles(t, grid, [&](int x, int y, float low, float high) {
            tiles.insert(tiles.end(), {int64_t(i), x, y});
            depths.insert(depths.end(), {low, high});
        });
    }
    const py::ssize_t n = py::ssize_t(tiles.size() / 3);
    return py::make_tuple(py::array_t<int64_t>({n, py::ssize_t(3)}, tiles.data()),
                          py::array_t<float>({n, py::ssize_t(2)}, depths.data()));
}

/// The tiles (x, y) along a ray in canonical space, and t where the ray enters and leaves each.
py::tuple walk(const std::array<float, 3>& o, const std::array<float, 3>& d, int n_tiles, double t_min,
               double t_max) {
    check_tiles(n_tiles);
    // The canonical space is that of the ball: centre 0, radius 1, axes as given.
    const FieldRay ray({vec3(o), 0, vec3(d), kInfinity}, FieldSpace{});
    std::vector<int64_t> tiles;
    std::vector<double> times;
    walk_tiles(CanonicalRay(ray, {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, t_min, t_max), n_tiles,
               [&](int x, int y, double in, double out) {
                   tiles.insert(tiles.end(), {x, y});
                   times.insert(times.end(), {in, out});
                   // Never ends the walk: all tiles are wanted.
                   return false;
               });
    const py::ssize_t n = py::ssize_t(tiles.size() / 2);
    return py::make_tuple(py::array_t<int64_t>({n, py::ssize_t(2)}, tiles.data()),
                          py::array_t<double>({n, py::ssize_t(2)}, times.data()));
}

/// The leaves of the depths [low, high], in the order of the ray.
std::vector<int> leaves(float z0, float z1, int count, const std::vector<float>& borders, float low,
                        float high, bool upwards, const std::string& how) {
    // As many leaves as a tree of halvings has
    if (count < 1 || count > 1 << kMostBspDepthOfTile || (count & (count - 1)) ||
        (!borders.empty() && int(borders.size()) != count))
        throw py::value_error("leaves must be a power of two with as many borders or none, got " +
                              std::to_string(count));
    const TileBsp bsp{z0, z1, count, borders.empty() ? nullptr : borders.data()};
    std::vector<int> order;
    const auto visit = [&](int l) {
        order.push_back(l);
        return false;
    };
    if (named<LeafWalk>("how", how) == LeafWalk::kLinear)
        walk_leaves(bsp, low, high, upwards, visit);
    else
        walk_leaves_by_stack(bsp, low, high, upwards, visit);
    return order;
}

uint64_t predicted(const std::shared_ptr<Scene>& scene, const FieldSettings& settings, int threads) {
    settings.validate();
    uint64_t bytes = 0;
    run_interruptible([&](Control& control) {
        const FieldTriangles triangles(scene, settings.kernel, settings.head_room);
        // The settings that "auto" would choose
        bytes = predicted_bytes(triangles, chosen_settings(triangles, settings, threads, control), threads,
                                control);
    });
    return bytes;
}

}  // namespace

void bind_vlf_parts(py::module_& m) {
    py::module_ v = m.def_submodule("vlf");
    v.def("cover_tiles", &cover, py::arg("triangles"), py::arg("n_tiles"),
          "Tiles of triangles in canonical space: (triangle, x, y) (K, 3) and depth ranges (K, 2).");
    v.def("walk_tiles", &walk, py::arg("origin"), py::arg("direction"), py::arg("n_tiles"),
          py::arg("t_min") = 0.0, py::arg("t_max") = double(kInfinity),
          "Tiles (K, 2) and t (K, 2) of a ray in canonical space.");
    v.def("walk_leaves", &leaves, py::arg("z0"), py::arg("z1"), py::arg("leaves"), py::arg("borders"),
          py::arg("low"), py::arg("high"), py::arg("upwards"), py::arg("how"));
    v.def(
        "expected_references",
        [](const std::shared_ptr<Scene>& scene, int n_tiles) {
            check_tiles(n_tiles);
            const FieldTriangles triangles(scene, TriangleKernel::kWatertight, 1);
            return expected_references(triangles.in_ball(), n_tiles);
        },
        py::arg("scene"), py::arg("n_tiles"),
        "Expected number of entries in the lists of one direction, without splits along the depth.");
    v.def("predicted_bytes", &predicted, py::arg("scene"), py::arg("settings"), py::arg("threads") = 0,
          "Bytes of a field before it is built.");
}

}  // namespace viscache::bindings

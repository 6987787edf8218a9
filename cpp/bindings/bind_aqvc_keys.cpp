// Keys of the quantized cache, their hashes and the resolution of the eye's side, vectorised.
#include "aqvc_keys.h"
#include "viscache/aqvc/columns.h"

namespace viscache::bindings {
namespace {

/// Keys (N, 15) of connections, and the continuous coordinates of their cells. The caller gives the
/// resolutions of both ends.
py::tuple full_keys(const AqvcParameters& p, std::array<float, 3> center, double radius,
                    const FloatArray& points, const FloatArray& normals, const DoubleArray& resolutions,
                    int semantic, const FloatArray& far, const FloatArray& far_normals,
                    const DoubleArray& far_resolutions, int dx, int dy) {
    const CellGrid grid(p, vec3(center), radius);
    const auto x = vec3s(points, "points"), n = vec3s(normals, "normals"), y = vec3s(far, "far"),
               m = vec3s(far_normals, "far_normals");
    const py::ssize_t count = py::ssize_t(x.size());
    // One row per connection, whether its key is valid or not: `valid` says which are.
    KeyArray keys({count, py::ssize_t(15)});
    py::array_t<double> place({count, py::ssize_t(3)});
    py::array_t<bool> valid(count);
    ClampCounts clamps;
    for (py::ssize_t i = 0; i < count; ++i) {
        const size_t k = size_t(i);
        const Anchor anchor = grid.anchor(x[k], n[k]);
        PlacedCell placed = grid.cell(anchor, grid.ladder.rung(resolutions.at(i), clamps));
        // The neighbour's cell; the coordinates stay those of the point.
        if (dx || dy) placed.cell = grid.neighbour(anchor, placed, dx, dy);
        FarKey far_key;
        const bool has_far =
            grid.far_key(Semantic(semantic), y[k], m[k], far_resolutions.at(i), far_key, clamps);
        const FullKey key = grid.full_key(placed.cell, far_key);
        std::copy(key.begin(), key.end(), keys.mutable_data(i, 0));
        double* f = place.mutable_data(i, 0);
        f[0] = placed.fx;
        f[1] = placed.fy;
        f[2] = placed.fz;
        valid.mutable_at(i) = anchor.valid && has_far;
    }
    return py::make_tuple(keys, place, valid, clamps_dict(clamps));
}

}  // namespace

void bind_aqvc_keys(py::module_& a) {
    a.def("resolution_eye", py::vectorize(resolution_eye), "AQVC Eq. 7, eye side: D_e, C_E, B_R.");
    a.def("full_keys", &full_keys, py::arg("parameters"), py::arg("center"), py::arg("radius"),
          py::arg("points"), py::arg("normals"), py::arg("resolutions"), py::arg("semantic"), py::arg("far"),
          py::arg("far_normals"), py::arg("far_resolutions"), py::arg("dx") = 0, py::arg("dy") = 0,
          "Keys of AQVC Sec. 3.3 and 3.5.");
    a.def(
        "hash_keys",
        [](const KeyArray& keys, const std::string& scheme) {
            py::array_t<uint32_t> out({keys.shape(0), py::ssize_t(2)});
            const FullKey* rows = key_rows(keys);
            for (py::ssize_t i = 0; i < keys.shape(0); ++i) {
                const KeyHash h = hash_key(rows[i], scheme_named(scheme));
                out.mutable_at(i, 0) = h.kappa;
                out.mutable_at(i, 1) = h.digest;
            }
            return out;
        },
        py::arg("keys"), py::arg("scheme") = "scheme2", "AQVC Eq. 10: (κ, c).");
}

}  // namespace viscache::bindings

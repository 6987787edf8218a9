// The numbered equations of the quantized cache, vectorised. Most serve tests.
#include <pybind11/pybind11.h>

#include "arrays.h"
#include "real_numbers.h"
#include "viscache/aqvc/bit_table.h"
#include "viscache/aqvc/columns.h"
#include "viscache/aqvc/pixel_order.h"

namespace viscache::bindings {
namespace {

using namespace py::literals;

using KeyArray = py::array_t<int32_t, py::array::c_style | py::array::forcecast>;

const FullKey* key_rows(const KeyArray& keys) {
    require_rows(keys, 15, "keys");
    return reinterpret_cast<const FullKey*>(keys.data());
}

HashScheme scheme_named(const std::string& name) {
    if (name == "scheme2") return HashScheme::kScheme2;
    if (name == "scheme1") return HashScheme::kScheme1;
    if (name == "scheme1_mixed") return HashScheme::kScheme1Mixed;
    throw py::value_error("scheme must be scheme2, scheme1 or scheme1_mixed, got " + name);
}

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
    KeyArray keys({count, py::ssize_t(15)});
    py::array_t<double> place({count, py::ssize_t(3)});
    py::array_t<bool> valid(count);
    ClampCounts clamps;
    for (py::ssize_t i = 0; i < count; ++i) {
        const size_t k = size_t(i);
        const Anchor anchor = grid.anchor(x[k], n[k]);
        PlacedCell placed = grid.cell(anchor, grid.ladder.rung(resolutions.at(i), clamps));
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
    return py::make_tuple(keys, place, valid,
                          py::dict("low"_a = clamps.low, "high"_a = clamps.high, "nan"_a = clamps.nan));
}

py::dict order(std::vector<uint32_t> x, std::vector<uint32_t> y, uint32_t width, uint32_t height,
               const AqvcParameters& p) {
    if (x.size() != y.size()) throw py::value_error("x and y must have equal lengths");
    EyeBlock eyes;
    eyes.position.resize(x.size());
    eyes.order_x = std::move(x);
    eyes.order_y = std::move(y);
    eyes.tile_width = width;
    eyes.tile_height = height;
    TileOrder order;
    OrderMaker().make(eyes, p, order);
    const uint32_t batch = p.batch ? uint32_t(p.batch) : 1024u;
    return py::dict("eye"_a = order.eye, "segment_end"_a = order.segment_end,
                    "run_end"_a = run_ends(order, batch));
}

void bind_table(py::module_& t) {
    py::class_<BitTable>(t, "BitTable", "The lossy table. `get` gives -1 for a miss.")
        .def(py::init([](uint64_t slots, int digest_bits, const std::string& scheme) {
                 return BitTable(slots, digest_bits, scheme_named(scheme));
             }),
             py::arg("slots"), py::arg("digest_bits") = 31, py::arg("scheme") = "scheme2")
        .def("get",
             [](const BitTable& t, const KeyArray& keys) {
                 const FullKey* rows = key_rows(keys);
                 py::array_t<int8_t> values(keys.shape(0));
                 for (py::ssize_t i = 0; i < keys.shape(0); ++i) {
                     const auto value = t.get(rows[i]);
                     values.mutable_at(i) = value ? int8_t(*value) : int8_t(-1);
                 }
                 return values;
             })
        .def("put",
             [](BitTable& t, const KeyArray& keys, const std::vector<bool>& visible) {
                 TableCounts counts;
                 const FullKey* rows = key_rows(keys);
                 if (visible.size() != size_t(keys.shape(0)))
                     throw py::value_error("visible must have one value per key");
                 for (py::ssize_t i = 0; i < keys.shape(0); ++i) t.put(rows[i], visible[size_t(i)], counts);
                 return py::dict("writes"_a = counts.writes, "evictions"_a = counts.evictions,
                                 "expected_false_hits"_a = counts.expected_false_hits);
             })
        .def("clear", &BitTable::clear)
        .def_property_readonly("slots", &BitTable::slots)
        .def_property_readonly("occupied", &BitTable::occupied);
}

}  // namespace

void bind_aqvc_keys(py::module_& a, py::module_& t) {
    t.def("expected_paths", py::vectorize(expected_paths), "AQVC Eq. 2.");
    t.def("patch_area_product", py::vectorize(patch_area_product), "AQVC Eq. 3.");
    t.def("patch_area", py::vectorize(patch_area), "AQVC Eq. 5.");
    t.def("resolution_pair", py::vectorize(resolution_pair), "AQVC Eq. 6 of D_e, D_l, C_E, B_R.");
    a.def("resolution_eye", py::vectorize(resolution_eye), "AQVC Eq. 7, eye side: D_e, C_E, B_R.");
    t.def("resolution_light", py::vectorize(resolution_light), "AQVC Eq. 7, light side: D_l, B_R.");
    t.def("resolution_environment", py::vectorize([](double density, bool printed) {
              return resolution_environment(density,
                                            printed ? EnvironmentRule::kPrinted : EnvironmentRule::kDerived);
          }),
          py::arg("density"), py::arg("printed") = false, "AQVC Eq. 9 of P(ω)·M.");
    t.def(
        "ladder",
        [](const DoubleArray& r, double c_r, double c_z) {
            const Ladder ladder(c_r, c_z);
            ClampCounts clamps;
            py::array_t<double> resolution(r.size());
            py::array_t<int32_t> slot(r.size());
            for (py::ssize_t i = 0; i < r.size(); ++i) {
                const Rung& rung = ladder.rung(r.data()[i], clamps);
                resolution.mutable_at(i) = rung.resolution;
                slot.mutable_at(i) = rung.slot;
            }
            return py::make_tuple(
                resolution, slot,
                py::dict("low"_a = clamps.low, "high"_a = clamps.high, "nan"_a = clamps.nan));
        },
        py::arg("r"), py::arg("c_r") = 1.2, py::arg("c_z") = 4.0, "AQVC Eq. 8: resolutions, slots, clamps.");
    a.def("full_keys", &full_keys, py::arg("parameters"), py::arg("center"), py::arg("radius"),
          py::arg("points"), py::arg("normals"), py::arg("resolutions"), py::arg("semantic"), py::arg("far"),
          py::arg("far_normals"), py::arg("far_resolutions"), py::arg("dx") = 0, py::arg("dy") = 0,
          "Keys of AQVC Sec. 3.3 and 3.5.");
    t.def(
        "octahedral_square",
        [](const FloatArray& w) {
            py::array_t<double> uv({w.shape(0), py::ssize_t(2)});
            for (py::ssize_t i = 0; i < w.shape(0); ++i) {
                const auto [u, v] = octahedral_square<double>(rows3(w, "w")[i]);
                uv.mutable_at(i, 0) = u;
                uv.mutable_at(i, 1) = v;
            }
            return uv;
        },
        "Octahedral map of directions to the unit square.");
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
    t.def("largest_prime", &largest_prime);
    t.def("order", &order, py::arg("x"), py::arg("y"), py::arg("width"), py::arg("height"),
          py::arg("parameters"), "Processing order of a tile's eye points (AQVC Sec. 4.3).");
    bind_table(t);
}

}  // namespace viscache::bindings

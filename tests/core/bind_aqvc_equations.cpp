// The numbered equations of the quantized cache, its table and its order of eye points.
#include "aqvc_keys.h"
#include "viscache/aqvc/pixel_order.h"
#include "viscache/aqvc/resolution.h"
#include "viscache/math/octahedral.h"

namespace viscache::bindings {
namespace {

using namespace py::literals;

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

void bind_resolutions(py::module_& t) {
    t.def("expected_paths", py::vectorize(expected_paths), "AQVC Eq. 2.");
    t.def("patch_area_product", py::vectorize(patch_area_product), "AQVC Eq. 3.");
    t.def("patch_area", py::vectorize(patch_area), "AQVC Eq. 5.");
    t.def("resolution_pair", py::vectorize(resolution_pair), "AQVC Eq. 6 of D_e, D_l, C_E, B_R.");
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
            return py::make_tuple(resolution, slot, clamps_dict(clamps));
        },
        py::arg("r"), py::arg("c_r") = 1.2, py::arg("c_z") = 4.0, "AQVC Eq. 8: resolutions, slots, clamps.");
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

void bind_aqvc_equations(py::module_& t) {
    bind_resolutions(t);
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
    t.def("largest_prime", &largest_prime);
    t.def("order", &order, py::arg("x"), py::arg("y"), py::arg("width"), py::arg("height"),
          py::arg("parameters"), "Processing order of a tile's eye points (AQVC Sec. 4.3).");
    bind_table(t);
}

}  // namespace viscache::bindings

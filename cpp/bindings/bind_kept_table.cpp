// Tables and rows of the quantized cache that are kept between frames.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include "arrays.h"
#include "gil.h"
#include "viscache/aqvc/kept_rows.h"
#include "viscache/aqvc/kept_table.h"
#include "viscache/aqvc/parameters.h"

namespace py = pybind11;

namespace viscache::bindings {

namespace {

template <class T>
std::vector<T> values_of(const py::array_t<T, py::array::c_style | py::array::forcecast>& a) {
    return {a.data(), a.data() + a.size()};
}

void bind_rows(py::module_& m) {
    using Longs = py::array_t<int64_t, py::array::c_style | py::array::forcecast>;
    py::class_<AqvcRows>(m, "AqvcRows", "See viscache.AqvcRows.")
        .def(py::init<uint64_t>(), py::arg("max_bytes"))
        .def("clear", &AqvcRows::clear)
        .def("commit", &AqvcRows::commit)
        .def_property_readonly("frames", &AqvcRows::frames)
        .def_property_readonly("cells", &AqvcRows::cells)
        .def_property_readonly("bytes", &AqvcRows::bytes)
        .def_property_readonly("tiles", &AqvcRows::tiles)
        .def(
            "state",
            [](const AqvcRows& rows, size_t tile, size_t group) -> py::tuple {
                // An error of Python's, instead of the core's for containers
                if (tile >= rows.tiles() || group >= kLightGroups) throw py::index_error("no such rows");
                const KeptRows::State s = rows.state(tile, int(group));
                return py::make_tuple(s.digest, s.row_words, array_of(s.cells), array_of(s.rows));
            },
            py::arg("tile"), py::arg("group"), "(digest, row_words, cells, rows) of finished frames.")
        .def("begin_restore", &AqvcRows::begin_restore, py::arg("tiles"), py::arg("frames"))
        .def(
            "restore",
            [](AqvcRows& rows, size_t tile, size_t group, uint64_t digest, uint64_t row_words,
               const Longs& cells, const WordArray& words) {
                if (tile >= rows.tiles() || group >= kLightGroups) throw py::index_error("no such rows");
                rows.restore(tile, int(group), {digest, row_words, values_of(cells), values_of(words)});
            },
            py::arg("tile"), py::arg("group"), py::arg("digest"), py::arg("row_words"), py::arg("cells"),
            py::arg("rows"));
}

}  // namespace

void bind_kept_table(py::module_& m) {
    bind_rows(m);
    PYBIND11_NUMPY_DTYPE(KeptEntry, slot, digest, visible, current);
    py::class_<KeptTable>(m, "KeptTable", "See viscache.AqvcTable.")
        .def(py::init([](uint64_t table_bytes, const AqvcParameters& p) {
                 return std::make_unique<KeptTable>(table_bytes, p.digest_bits, p.hash);
             }),
             py::arg("table_bytes"), py::arg("parameters"))
        .def(
            "entries",
            [](const KeptTable& t) -> py::array {
                py::array_t<KeptEntry> entries{py::ssize_t(t.bits().occupied())};
                // As large as the table says now; the caller keeps frames from ending meanwhile.
                const std::span to(entries.mutable_data(), size_t(entries.size()));
                {
                    const WithoutGil release;
                    t.read(to);
                }
                return entries;
            },
            "Occupied slots in ascending order: slot, digest, visible, current.")
        .def("next_epoch", &KeptTable::next_epoch)
        .def_property_readonly("epoch", &KeptTable::epoch)
        .def_property_readonly("frames", &KeptTable::frames)
        .def_property_readonly("slots", [](const KeptTable& t) { return t.bits().slots(); })
        .def_property_readonly("occupied", [](const KeptTable& t) { return t.bits().occupied(); });
}

}  // namespace viscache::bindings

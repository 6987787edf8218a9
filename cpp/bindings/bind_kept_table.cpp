// A table of the quantized cache that is kept between frames.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include "viscache/aqvc/kept_table.h"
#include "viscache/aqvc/parameters.h"

namespace py = pybind11;

namespace viscache::bindings {

void bind_kept_table(py::module_& m) {
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
                const std::span to(entries.mutable_data(), size_t(entries.size()));
                {
                    const py::gil_scoped_release release;
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

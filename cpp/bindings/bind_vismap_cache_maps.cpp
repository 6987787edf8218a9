// Parts of the visibility-map cache: maps and weights.
#include "map_words.h"
#include "viscache/math/morton.h"
#include "viscache/vismap/dilation.h"
#include "viscache/vismap/weights.h"

namespace viscache::bindings {

namespace {

py::array_t<Word> dilated(const WordArray& bits, int m, int level) {
    const Word* map = checked_map(bits, m);
    // Level 3 exists only for large maps.
    if (level < 1 || level > dilations(m))
        throw py::value_error("level must be in [1, " + std::to_string(dilations(m)) + "], got " +
                              std::to_string(level));
    py::array_t<Word> out(py::ssize_t(dilated_words(m, level)));
    dilate(m, map, level, out.mutable_data());
    return out;
}

}  // namespace

void bind_vismap_cache_maps(py::module_& m) {
    py::module_ v = m.def_submodule("vismap", "The visibility-map cache (VisMap).");
    v.def("morton2", py::vectorize(morton2), py::arg("x"), py::arg("y"), "Z-order numbers of cells.");
    v.def(
        "record_nbytes", [](int m) { return record_nbytes(checked_m(m)); }, py::arg("m"),
        "Size of a record in bytes by the paper's formula.");
    v.def("dilated", &dilated, py::arg("bits"), py::arg("m"), py::arg("level"), "V^level of a map.");
    v.def("record_weight", py::vectorize(record_weight), py::arg("t"), py::arg("theta"), py::arg("lambda_"),
          "w of Eq. 9; t = d / d_max, θ in radians.");
}

}  // namespace viscache::bindings

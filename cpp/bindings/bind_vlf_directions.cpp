// Directions of the visibility field.

#include "arrays.h"
#include "viscache/vlf/directions.h"

namespace viscache::bindings {

namespace {

/// One by one with their errors: a zero vector has no nearest axis.
py::array_t<uint32_t> nearest_direction(const FloatArray& d, uint32_t n_directions) {
    const Directions& directions = directions_of(n_directions);
    const std::span<const Vec3> rows(rows3(d, "directions"), size_t(d.shape(0)));
    py::array_t<uint32_t> nearest(d.shape(0));
    uint32_t* out = nearest.mutable_data();
    for (size_t i = 0; i < rows.size(); ++i) {
        if (!is_finite(rows[i]) || rows[i] == Vec3{})
            throw py::value_error("directions must be finite and not zero, row " + std::to_string(i) +
                                  " is not");
        out[i] = directions.nearest(rows[i]);
    }
    return nearest;
}

py::array_t<float> frames(uint32_t n_directions) {
    const auto all = directions_of(n_directions).frames();
    py::array_t<float> a({py::ssize_t(all.size()), py::ssize_t(3), py::ssize_t(3)});
    // Frames are nine floats in a row: u, v, w.
    std::memcpy(a.mutable_data(), all.data(), all.size_bytes());
    return a;
}

}  // namespace

void bind_vlf_directions(py::module_& m) {
    py::module_ v = m.def_submodule("vlf", "The visibility field.");
    v.def(
        "directions",
        [](uint32_t n) {
            const auto axes = directions_of(n).axes();
            return from_vec3s({axes.begin(), axes.end()});
        },
        py::arg("n_directions"), "Unit axes (l, 3).");
    v.def("direction_frames", &frames, py::arg("n_directions"), "Rows u, v, w of (l, 3, 3).");
    v.def(
        "direction_weights",
        [](uint32_t n) {
            const auto weights = directions_of(n).weights();
            return py::array_t<float>(py::ssize_t(weights.size()), weights.data());
        },
        py::arg("n_directions"), "Solid angles (l,), in sr.");
    v.def("nearest_direction", &nearest_direction, py::arg("directions"), py::arg("n_directions"),
          "Index of the axis nearest to each row.");
}

}  // namespace viscache::bindings

// The equal-area map and patterns of directions.
#include <pybind11/native_enum.h>

#include "real_numbers.h"
#include "rows.h"
#include "viscache/math/equal_area_batch.h"
#include "viscache/sampling/direction_pattern.h"

namespace viscache::bindings {

namespace {

void bind_equal_area(py::module_& s) {
    s.def(
        "direction_to_equal_area",
        [](const FloatArray& d) {
            return map_all_rows<Vec3, Vec2>(
                d, "d", [](auto directions, auto points) { directions_to_equal_area(directions, points); });
        },
        py::arg("d"), "Equal-area octahedral map of unit vectors (N, 3) into [0, 1]², (N, 2).");
    s.def(
        "equal_area_to_direction",
        [](const FloatArray& p) {
            return map_all_rows<Vec2, Vec3>(
                p, "p", [](auto points, auto directions) { equal_area_to_directions(points, directions); });
        },
        py::arg("p"), "Its inverse: (N, 2) to unit vectors (N, 3).");
}

void bind_directions(py::module_& s) {
    py::native_enum<PatternKind>(s, "PatternKind", "enum.Enum", "Position of a direction inside its cell.")
        .value("CENTRES", PatternKind::kCentres)
        .value("JITTERED", PatternKind::kJittered)
        .value("LLOYD", PatternKind::kLloyd)
        .finalize();
    s.def(
        "direction_pattern",
        [](int map_size, PatternKind kind, uint64_t seed) {
            // Lloyd's iteration over 256² cells takes seconds; larger maps have no use here.
            if (map_size < 1 || map_size > 256)
                throw py::value_error("map_size must be in [1, 256], got " + std::to_string(map_size));
            return from_vec3s(direction_pattern(map_size, kind, seed));
        },
        py::arg("map_size"), py::arg("kind"), py::arg("seed"),
        "Unit vectors (map_size², 3), one in each cell of the equal-area map, row by row.");
}

}  // namespace

void bind_sampling(py::module_& m) {
    py::module_ s = m.def_submodule("sampling", "Directions, light and reflection.");
    bind_equal_area(s);
    bind_directions(s);
}

}  // namespace viscache::bindings

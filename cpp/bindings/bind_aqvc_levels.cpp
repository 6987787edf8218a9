// Keys of four levels, hashed one by one or all at once, for tests and `viscache bench aqvc-lookup`.
#include <pybind11/pybind11.h>

#include "arrays.h"
#include "real_numbers.h"
#include "viscache/aqvc/key_levels.h"
#include "viscache/render/stage_clock.h"

namespace viscache::bindings {
namespace {

/// κ and digest of the keys of every point with its light at four resolutions, and the CPU seconds.
py::tuple level_hashes(const AqvcParameters& p, std::array<float, 3> center, double radius,
                       const FloatArray& points, const FloatArray& normals, const DoubleArray& resolutions,
                       const FloatArray& lights, bool at_once) {
    const CellGrid grid(p, vec3(center), radius);
    const auto x = vec3s(points, "points"), n = vec3s(normals, "normals"), y = vec3s(lights, "lights");
    require_rows(resolutions, int(kLevelsAtOnce), "resolutions");
    if (n.size() != x.size() || y.size() != x.size() || size_t(resolutions.shape(0)) != x.size())
        throw py::value_error("points, normals, resolutions and lights must have equal lengths");
    const py::ssize_t count = py::ssize_t(x.size()), levels = py::ssize_t(kLevelsAtOnce);
    py::array_t<uint32_t> kappa({count, levels}), digest({count, levels});
    ClampCounts clamps;
    // The time includes making the keys, in both ways alike: what differs is the hashing.
    const double start = thread_cpu_seconds();
    for (size_t i = 0; i < x.size(); ++i) {
        const Anchor anchor = grid.anchor(x[i], n[i]);
        FarKey far;
        grid.far_key(Semantic::kPoint, y[i], {}, 1, far, clamps);
        LevelKeys keys;
        LevelHashes hashes;
        for (size_t d = 0; d < kLevelsAtOnce; ++d) {
            const double r = resolutions.data()[i * kLevelsAtOnce + d];
            keys[d] = grid.full_key(grid.cell(anchor, grid.ladder.rung(r, clamps)).cell, far);
            if (!at_once) hashes[d] = hash_key(keys[d], HashScheme::kScheme2);
        }
        if (at_once) hashes = hash_levels(keys);
        for (size_t d = 0; d < kLevelsAtOnce; ++d) {
            kappa.mutable_data()[i * kLevelsAtOnce + d] = hashes[d].kappa;
            digest.mutable_data()[i * kLevelsAtOnce + d] = hashes[d].digest;
        }
    }
    return py::make_tuple(kappa, digest, thread_cpu_seconds() - start);
}

}  // namespace

void bind_aqvc_levels(py::module_& a) {
    a.def(
        "level_hashes", &level_hashes, py::arg("parameters"), py::arg("center"), py::arg("radius"),
        py::arg("points"), py::arg("normals"), py::arg("resolutions"), py::arg("lights"), py::kw_only(),
        py::arg("at_once"),
        "κ and digest (N, 4) of points (N, 3) at four resolutions (N, 4) with one point light each, and the "
        "CPU seconds. `at_once` hashes four levels together instead of one by one.");
}

}  // namespace viscache::bindings

// Shadow maps: their settings, and look-ups of one light for tests.

#include "caster_queries.h"
#include "real_numbers.h"
#include "viscache/render/shared_lights.h"
#include "viscache/visibility/shadow_map.h"

namespace viscache::bindings {

namespace {

/// Looks points up in the map of one light.
py::tuple lit_by_light(const RayCaster& caster, const ShadowMapSettings& settings, Vec3 far, bool direction,
                       const FloatArray& positions, const FloatArray& normals, Vec3 center, float radius,
                       int threads) {
    require_same_rows(positions, normals, "positions and normals");
    const auto p = vec3s(positions, "positions"), n = vec3s(normals, "normals");
    SharedLights light;
    light.add(far, {}, far, {1, 1, 1}, 0);
    light.ends.semantic = direction ? Semantic::kDirection : Semantic::kPoint;
    light.pad();
    const std::array<const FarEnds*, 1> lights{&light.ends};
    Control control;
    const ShadowMaps maps(caster, {center, radius, 2 * radius}, settings, lights, threads, control);
    py::array_t<bool> lit{py::ssize_t(p.size())};
    for (size_t first = 0; first < p.size(); first += 16) {
        Receivers16 r;
        for (size_t i = 0; i < 16; ++i) {
            const size_t at = std::min(first + i, p.size() - 1);
            r.x[i] = p[at].x;
            r.y[i] = p[at].y;
            r.z[i] = p[at].z;
            r.nx[i] = n[at].x;
            r.ny[i] = n[at].y;
            r.nz[i] = n[at].z;
        }
        const uint16_t bits = maps.lit16(light.ends, 0, r);
        for (size_t i = first; i < std::min(first + 16, p.size()); ++i)
            lit.mutable_at(py::ssize_t(i)) = bits >> (i - first) & 1;
    }
    const auto depth = maps.depths(light.ends, 0);
    const py::ssize_t side = settings.resolution;
    py::array_t<float> depths({py::ssize_t(depth.size()) / (side * side), side, side});
    std::copy(depth.begin(), depth.end(), depths.mutable_data());
    return py::make_tuple(lit, depths);
}

}  // namespace

void bind_shadow_map(py::module_& m) {
    py::class_<ShadowMapSettings>(m, "ShadowMapSettings", "See viscache.ShadowMap.")
        .def(py::init<>())
        .def_readwrite("resolution", &ShadowMapSettings::resolution)
        .def_readwrite("bias", &ShadowMapSettings::bias)
        .def_readwrite("slope_bias", &ShadowMapSettings::slope_bias)
        .def_readwrite("vpls", &ShadowMapSettings::vpls)
        .def_readwrite("max_bytes", &ShadowMapSettings::max_bytes)
        .def("validate", &ShadowMapSettings::validate);
    py::module_ t = m.def_submodule("_testing");
    t.def(
        "lit_by_light",
        [](const RayCaster& caster, const ShadowMapSettings& settings, std::array<float, 3> far,
           bool direction, const FloatArray& positions, const FloatArray& normals,
           std::array<float, 3> center, float radius, int threads) {
            return lit_by_light(caster, settings, vec3(far), direction, positions, normals, vec3(center),
                                radius, threads);
        },
        py::arg("caster"), py::arg("settings"), py::arg("far"), py::kw_only(), py::arg("direction"),
        py::arg("positions"), py::arg("normals"), py::arg("center"), py::arg("radius"),
        py::arg("threads") = 1,
        "Points with unit normals looked up in one light's map: lit (N,), depths (faces, rows, columns). "
        "`far` is a position, or a unit direction towards the light.");
}

}  // namespace viscache::bindings

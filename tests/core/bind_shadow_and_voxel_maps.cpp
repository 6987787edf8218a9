// Look-ups in the shadow map of one light, and in a voxel map of given connections.
#include "caster_queries.h"
#include "viscache/oracles/kept_voxels.h"
#include "viscache/oracles/shadow_map.h"
#include "viscache/render/shared_lights.h"

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
    const ShadowMaps maps(caster, {center, radius}, settings, lights, threads, control);
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

/// Fills a voxel map over a box with given connections.
py::tuple learnt_map(const NeePlusPlusSettings& settings, Float3 low, Float3 high, const FloatArray& near,
                     const FloatArray& far, const BoolArray& seen, bool direction) {
    require_same_rows(near, far, "near and far");
    const auto from = vec3s(near, "near"), to = vec3s(far, "far");
    if (seen.ndim() != 1 || size_t(seen.size()) != from.size())
        throw std::invalid_argument("seen must have one value per row of near");
    VoxelVisibility map({vec3(low), vec3(high)}, settings);
    const Semantic semantic = direction ? Semantic::kDirection : Semantic::kPoint;
    const py::ssize_t n = py::ssize_t(from.size());
    py::array_t<uint32_t> near_cell(n), far_cell(n);
    for (py::ssize_t i = 0; i < n; ++i) {
        near_cell.mutable_at(i) = map.voxel(from[size_t(i)]);
        far_cell.mutable_at(i) = map.far_cell(semantic, to[size_t(i)]);
        map.add(near_cell.at(i), far_cell.at(i), seen.at(i));
    }
    py::array_t<double> visibility(n), probability(n);
    for (py::ssize_t i = 0; i < n; ++i) {
        visibility.mutable_at(i) = map.visibility(near_cell.at(i), far_cell.at(i));
        probability.mutable_at(i) = map.probability(near_cell.at(i), far_cell.at(i));
    }
    return py::make_tuple(near_cell, far_cell, visibility, probability);
}

}  // namespace

void bind_shadow_and_voxel_maps(py::module_& t) {
    t.def(
        "lit_by_light",
        [](const RayCaster& caster, const ShadowMapSettings& settings, Float3 far, bool direction,
           const FloatArray& positions, const FloatArray& normals, Float3 center, float radius, int threads) {
            return lit_by_light(caster, settings, vec3(far), direction, positions, normals, vec3(center),
                                radius, threads);
        },
        py::arg("caster"), py::arg("settings"), py::arg("far"), py::kw_only(), py::arg("direction"),
        py::arg("positions"), py::arg("normals"), py::arg("center"), py::arg("radius"),
        py::arg("threads") = 1,
        "Points with unit normals looked up in one light's map: lit (N,), depths (faces, rows, columns). "
        "`far` is a position, or a unit direction towards the light.");
    t.def(
        "learnt_map", &learnt_map, py::arg("settings"), py::arg("low"), py::arg("high"), py::arg("near"),
        py::arg("far"), py::arg("seen"), py::kw_only(), py::arg("direction") = false,
        "Cells of both ends (N,), then the visibility and probability of every connection in the filled map. "
        "`far` holds places, or directions towards the light.");
}

}  // namespace viscache::bindings

// Environment maps and BSDFs, evaluated for rows of arrays.
#include <map>

#include "described.h"
#include "gil.h"
#include "rows.h"
#include "viscache/scene/bsdf.h"
#include "viscache/scene/envmap.h"

namespace viscache::bindings {

namespace {

EnvironmentMap environment_from(const FloatArray& pixels, Float3 scale,
                                const std::optional<DoubleArray>& to_world, int resolution, int threads) {
    const Image image = image_from(pixels);
    Affine rotation;
    // The rotation only: an environment has no position.
    if (to_world) {
        require_rows(*to_world, 3, "to_world");
        if (to_world->shape(0) != 3)
            throw py::value_error("to_world must have shape (3, 3), got " + shape_text(*to_world));
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) rotation.m[i][j] = to_world->at(i, j);
    }
    // Read from Python before, so the resampling runs without the lock.
    const WithoutGil release;
    return EnvironmentMap::from_latlong(image, vec3(scale), rotation, resolution, threads);
}

std::vector<EnvironmentMap::Sample> looked_up(const EnvironmentMap& e, std::span<const Vec3> wi) {
    std::vector<EnvironmentMap::Sample> found(wi.size());
    e.look_up(wi, found);
    return found;
}

void bind_environment(py::module_& s) {
    py::class_<EnvironmentMap>(s, "EnvironmentMap", "Environment light on the equal-area octahedral map.")
        .def_static(
            "constant", [](Float3 radiance) { return EnvironmentMap::constant(vec3(radiance)); },
            py::arg("radiance"))
        .def_static("from_latlong", &environment_from, py::arg("pixels"), py::kw_only(),
                    py::arg("scale") = Float3{1, 1, 1}, py::arg("to_world") = py::none(),
                    py::arg("resolution") = 0, py::arg("threads") = 0,
                    "Resample a lat-long image (H, W, C); to_world (3, 3) rotates the map into the world.")
        .def(
            "eval",
            [](const EnvironmentMap& e, const FloatArray& wi) {
                return map_all_rows<Vec3, Rgb>(wi, "wi", [&](auto directions, auto radiance) {
                    const auto found = looked_up(e, directions);
                    for (size_t i = 0; i < found.size(); ++i) radiance[i] = found[i].radiance;
                });
            },
            py::arg("wi"), "Radiance (N, 3) that arrives from unit vectors (N, 3).")
        .def(
            "pdf",
            [](const EnvironmentMap& e, const FloatArray& wi) {
                return map_all_rows<Vec3, float>(wi, "wi", [&](auto directions, auto pdf) {
                    const auto found = looked_up(e, directions);
                    for (size_t i = 0; i < found.size(); ++i) pdf[i] = found[i].pdf;
                });
            },
            py::arg("wi"), "Density of `sample` per solid angle, (N,).")
        .def(
            "sample",
            [](const EnvironmentMap& e, const FloatArray& u) {
                // `map_rows` returns the last of three results; the other two are collected on the way.
                std::vector<Vec3> radiance, wi;
                const auto pdf = map_rows<Vec2>(u, "u", [&](Vec2 v) {
                    const auto sample = e.sample(v);
                    wi.push_back(sample.wi);
                    radiance.push_back(sample.radiance);
                    return sample.pdf;
                });
                return std::tuple(from_vec3s(wi), from_vec3s(radiance), pdf);
            },
            py::arg("u"), "Directions (N, 3), radiances (N, 3) and densities (N,).")
        .def_property_readonly("pixels",
                               [](const EnvironmentMap& e) {
                                   return from_vec3s(e.pixels()).reshape({e.resolution(), e.resolution(), 3});
                               })
        .def_property_readonly("resolution", &EnvironmentMap::resolution)
        .def_property_readonly("is_constant", &EnvironmentMap::is_constant)
        .def_property_readonly("total_power", &EnvironmentMap::total_power)
        .def_property_readonly("power_ratio", &EnvironmentMap::power_ratio);
}

/// The same metal, which lives as long as the process: those of scenes live in the scene.
const Conductor& kept(const Conductor& metal) {
    static std::map<std::array<float, 6>, Conductor> metals;
    const auto [e, k] = metal;
    return metals.try_emplace({e.x, e.y, e.z, k.x, k.y, k.z}, metal).first->second;
}

void bind_shading_point(py::module_& s) {
    py::class_<ShadingPoint>(s, "ShadingPoint", "Normals and material of a shaded point.")
        .def(py::init([](MaterialKind kind, Float3 wo, Float3 ns, Float3 ng, Float3 base, Float3 specular,
                         float roughness, float eta, CoatKind coat, bool nonlinear, Float3 metal_eta,
                         Float3 metal_k, bool beckmann, float f90) {
                 // In the order of the struct's members; what it has no place for is set below.
                 ShadingPoint sp{
                     vec3(ng), vec3(ns), normalize(vec3(wo)), vec3(base), vec3(specular), roughness,
                     kind,     eta};
                 if (coat == CoatKind::kFresnelMix)
                     sp.mix = {true, f90, max_component(sp.specular), f90};
                 else if (coat != CoatKind::kNone)
                     sp.coat = &coat_of(coat, eta, roughness, nonlinear);
                 const Conductor metal{vec3(metal_eta), vec3(metal_k)};
                 if (metal.is_given()) sp.metal = &kept(metal);
                 sp.beckmann = beckmann || coat == CoatKind::kBeckmann;
                 return sp;
             }),
             py::arg("kind"), py::arg("wo"), py::kw_only(), py::arg("ns") = Float3{0, 0, 1},
             py::arg("ng") = Float3{0, 0, 1}, py::arg("base") = Float3{0, 0, 0},
             py::arg("specular") = Float3{0, 0, 0}, py::arg("roughness") = 0.1f, py::arg("eta") = 1.5f,
             py::arg("coat") = CoatKind::kNone, py::arg("nonlinear") = false,
             py::arg("metal_eta") = Float3{0, 0, 0}, py::arg("metal_k") = Float3{0, 0, 0},
             py::arg("beckmann") = false, py::arg("f90") = 1.f);
    s.def(
        "eval_bsdf",
        [](const ShadingPoint& sp, const FloatArray& wi) {
            return map_rows<Vec3>(wi, "wi", [&](Vec3 w) { return eval_bsdf(sp, w); });
        },
        py::arg("sp"), py::arg("wi"), "f without the cosine factor, (N, 3).");
}

}  // namespace

void bind_light_and_reflection(py::module_& m) {
    py::module_ s = m.def_submodule("sampling");
    bind_environment(s);
    bind_shading_point(s);
}

}  // namespace viscache::bindings

// Warps of the unit square and microfacet distributions, evaluated for rows of arrays.

#include <limits>

#include "isa_argument.h"
#include "real_numbers.h"
#include "rows.h"
#include "viscache/sampling/hemisphere_batch.h"
#include "viscache/sampling/warp.h"

namespace viscache::bindings {

namespace {

template <class F>
void def_warp(py::module_& s, const char* name, F f, const char* doc) {
    s.def(name, [f](const FloatArray& u) { return map_rows<Vec2>(u, "u", f); }, py::arg("u"), doc);
}

py::tuple first_hemisphere_batch(uint32_t scramble_x, uint32_t scramble_y, Float3 normal, bool cosine,
                                 const std::optional<std::string>& isa) {
    HemisphereBatch batch;
    hemisphere_batch({scramble_x, scramble_y, frame_around(normalize(vec3(normal))), cosine}, 0,
                     HemisphereBatch::kSize, batch, isa_of(isa));
    std::vector<Vec3> directions;
    for (size_t i = 0; i < HemisphereBatch::kSize; ++i)
        directions.push_back({batch.x[i], batch.y[i], batch.z[i]});
    return py::make_tuple(from_vec3s(directions), py::array_t<float>(HemisphereBatch::kSize, batch.cosine));
}

void bind_shapes(py::module_& t) {
    t.def(
        "hemisphere_batch", &first_hemisphere_batch, py::arg("scramble_x"), py::arg("scramble_y"),
        py::arg("normal"), py::arg("cosine") = true, py::arg("isa") = py::none(),
        "The first 32 directions (N, 3) of a randomised (0,2)-sequence around a normal, and their cosines.");
    def_warp(t, "square_to_disk_concentric", square_to_disk_concentric, "Uniform on the unit disk, (N, 2).");
    def_warp(t, "square_to_cosine_hemisphere", square_to_cosine_hemisphere,
             "Cosine-weighted around +z, (N, 3).");
    def_warp(t, "square_to_uniform_hemisphere", square_to_uniform_hemisphere, "Uniform around +z, (N, 3).");
    def_warp(t, "square_to_uniform_sphere", square_to_uniform_sphere, "Uniform on the sphere, (N, 3).");
    def_warp(t, "square_to_triangle", square_to_triangle, "Weights of vertices 1 and 2, (N, 2).");
    t.def(
        "square_to_uniform_cone",
        [](const FloatArray& u, float cos_max) {
            return map_rows<Vec2>(u, "u", [&](Vec2 v) { return square_to_uniform_cone(v, cos_max); });
        },
        py::arg("u"), py::arg("cos_max"), "Uniform in the cone around +z, (N, 3).");
    t.def(
        "pdf_cosine_hemisphere",
        [](const FloatArray& w) { return map_rows<Vec3>(w, "w", pdf_cosine_hemisphere); }, py::arg("w"),
        "Density per solid angle, (N,).");
    t.def("pdf_uniform_hemisphere", &pdf_uniform_hemisphere, "Density per solid angle.");
    t.def("pdf_uniform_sphere", &pdf_uniform_sphere, "Density per solid angle.");
    t.def("pdf_uniform_cone", &pdf_uniform_cone, py::arg("cos_max"), "Density per solid angle.");
    t.def(
        "sample_sphere_light",
        [](Float3 center, float radius, Float3 origin, const FloatArray& u) -> py::object {
            std::vector<Vec3> p, n;
            std::vector<float> pdf_solid_angle, pdf_area;
            bool outside = true;
            map_rows<Vec2>(u, "u", [&](Vec2 v) {
                const auto sample = sample_sphere_light(vec3(center), radius, vec3(origin), v);
                if (!sample) {
                    outside = false;
                    return 0.f;
                }
                p.push_back(sample->p);
                n.push_back(sample->n);
                pdf_solid_angle.push_back(sample->pdf_solid_angle);
                pdf_area.push_back(sample->pdf_area);
                return 0.f;
            });
            if (!outside) return py::none();
            return py::make_tuple(
                from_vec3s(p), from_vec3s(n),
                py::array_t<float>(py::ssize_t(pdf_solid_angle.size()), pdf_solid_angle.data()),
                py::array_t<float>(py::ssize_t(pdf_area.size()), pdf_area.data()));
        },
        py::arg("center"), py::arg("radius"), py::arg("origin"), py::arg("u"),
        "Points, normals, densities per solid angle and per area; None unless `origin` is outside.");
}

void bind_microfacets(py::module_& t) {
    t.def(
        "ggx_d",
        [](const FloatArray& h, float alpha) {
            return map_rows<Vec3>(h, "h", [&](Vec3 v) { return ggx_d(v, alpha); });
        },
        py::arg("h"), py::arg("alpha"), "Density of microfacet normals (N, 3), local frame.");
    t.def(
        "smith_g1",
        [](const FloatArray& cos_w, float alpha) {
            return map_rows<float>(cos_w, "cos_w", [&](float c) { return smith_g1(c, alpha); });
        },
        py::arg("cos_w"), py::arg("alpha"), "Fraction of the microfacets that are visible from a direction.");
    t.def("smith_g2", &smith_g2, py::arg("cos_i"), py::arg("cos_o"), py::arg("alpha"), "Separable: G1 · G1.");
    t.def(
        "sample_ggx_vndf",
        [](Float3 wo, float alpha, const FloatArray& u) {
            return map_rows<Vec2>(u, "u", [&](Vec2 v) { return sample_ggx_vndf(vec3(wo), alpha, v); });
        },
        py::arg("wo"), py::arg("alpha"), py::arg("u"),
        "Microfacet normals visible from wo (wo.z > 0), (N, 3).");
    t.def(
        "pdf_ggx_vndf",
        [](Float3 wo, const FloatArray& h, float alpha) {
            return map_rows<Vec3>(h, "h", [&](Vec3 v) { return pdf_ggx_vndf(vec3(wo), v, alpha); });
        },
        py::arg("wo"), py::arg("h"), py::arg("alpha"), "Density per solid angle of the normals h (N, 3).");
    t.def(
        "schlick",
        [](Float3 f0, const FloatArray& cosine) {
            return map_rows<float>(cosine, "cosine", [&](float c) { return schlick(vec3(f0), c); });
        },
        py::arg("f0"), py::arg("cosine"),
        "Fresnel reflectance (N, 3) from the reflectance at normal incidence.");
    t.def(
        "fresnel_dielectric",
        [](const FloatArray& cos_i, float eta) {
            return map_rows<float>(cos_i, "cos_i", [&](float c) { return fresnel_dielectric(c, eta); });
        },
        py::arg("cos_i"), py::arg("eta"), "Unpolarised reflectance; cos_i < 0: from inside.");
    t.def(
        "refract",
        [](const FloatArray& wo, Float3 n, float eta_ratio) {
            constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
            return map_rows<Vec3>(wo, "wo", [&](Vec3 w) {
                return refract(w, vec3(n), eta_ratio).value_or(Vec3{kNone, kNone, kNone});
            });
        },
        py::arg("wo"), py::arg("n"), py::arg("eta_ratio"),
        "Refracted directions (N, 3); NaN: total reflection.");
}

}  // namespace

void bind_warp(py::module_& t) {
    bind_shapes(t);
    bind_microfacets(t);
}

}  // namespace viscache::bindings

#pragma once
// Parts of a scene description to and from plain Python objects.

#include <algorithm>
#include <cstring>
#include <span>

#include "arrays.h"
#include "gil.h"
#include "real_numbers.h"
#include "viscache/scene/description.h"

namespace viscache::bindings {

inline py::array_t<uint32_t> from_triangles(const std::vector<Vec3u>& t) {
    py::array_t<uint32_t> a({py::ssize_t(t.size()), py::ssize_t(3)});
    if (!t.empty()) std::memcpy(a.mutable_data(), t.data(), t.size() * sizeof(Vec3u));
    return a;
}

inline py::list affine_rows(const Affine& t) {
    py::list rows;
    for (const auto& row : t.m) rows.append(py::cast(row));
    return rows;
}

/// An image from an array (H, W, 1..4) of linear pixels.
inline Image image_from(const FloatArray& pixels) {
    if (pixels.ndim() != 3 || pixels.shape(2) < 1 || pixels.shape(2) > 4)
        throw py::value_error("pixels must have shape (H, W, 1..4), got " + shape_text(pixels));
    Image image;
    image.height = int(pixels.shape(0));
    image.width = int(pixels.shape(1));
    image.channels = int(pixels.shape(2));
    // Copied: the description outlives the array.
    image.pixels.assign(pixels.data(), pixels.data() + pixels.size());
    return image;
}

/// Linear floats, also of images of bytes.
inline py::array_t<float> pixels_of(const Image& i) {
    py::array_t<float> a({py::ssize_t(i.height), py::ssize_t(i.width), py::ssize_t(i.channels)});
    float* out = a.mutable_data();
    {
        const WithoutGil release;  // a large image takes a second
        std::copy(i.pixels.begin(), i.pixels.end(), out);
        const auto channels = size_t(i.channels);
        for (size_t c = 0; c < channels; ++c) {
            // A table of 256 values per channel turns bytes, sRGB or linear, into floats.
            const float* values = i.values_of(int(c));
            for (size_t k = c; k < i.bytes.size(); k += channels) out[k] = values[i.bytes[k]];
        }
    }
    return a;
}

inline py::dict material_dict(const Material& m) {
    return py::dict(
        py::arg("kind") = m.kind, py::arg("base_color") = array3(m.base_color),
        py::arg("specular") = array3(m.specular), py::arg("roughness") = m.roughness, py::arg("eta") = m.eta,
        py::arg("two_sided") = m.two_sided, py::arg("base_texture") = m.base_texture,
        py::arg("alpha_texture") = m.alpha_texture, py::arg("alpha_cutoff") = m.alpha_cutoff,
        py::arg("coat") = m.coat, py::arg("nonlinear") = m.nonlinear, py::arg("thin") = m.thin,
        py::arg("opacity") = m.opacity, py::arg("metallic") = m.metallic,
        py::arg("metallic_roughness_texture") = m.metallic_roughness_texture,
        py::arg("roughness_texture") = m.roughness_texture, py::arg("metal_eta") = array3(m.metal.eta),
        py::arg("metal_k") = array3(m.metal.k), py::arg("beckmann") = m.beckmann, py::arg("f90") = m.f90,
        py::arg("transmission") = array3(m.transmission));
}

/// Names of the falloffs of spot lights, in the order of `Falloff`.
constexpr const char* kFalloffNames[] = {"none", "angle", "quadratic", "quartic", "smooth"};

/// In the order of `Wrap`.
constexpr const char* kWrapNames[] = {"repeat", "mirror", "clamp"};

/// Makes the dict of a point light that of a spot light.
inline void add_cone(py::dict& light, const SpotCone& cone) {
    light["kind"] = "spot";
    light["axis"] = array3(cone.axis);
    light["cone_deg"] =
        py::make_tuple(std::acos(cone.cos_inner) * 180 / kPi, std::acos(cone.cos_outer) * 180 / kPi);
    light["falloff"] = kFalloffNames[size_t(cone.falloff)];
}

/// One dict per light with its kind and its values. Only the meshes in `meshes` are considered.
inline py::list light_dicts(const SceneDescription& d, std::span<const Mesh> meshes) {
    py::list out;
    for (const PointLight& l : d.point_lights) {
        py::dict light(py::arg("kind") = "point", py::arg("position") = array3(l.position),
                       py::arg("intensity") = array3(l.intensity));
        if (l.cone.falloff != Falloff::kNone) add_cone(light, l.cone);
        out.append(light);
    }
    for (const DirectionalLight& l : d.directional_lights)
        out.append(py::dict(py::arg("kind") = "directional", py::arg("direction") = array3(l.direction),
                            py::arg("irradiance") = array3(l.irradiance)));
    // Emitting meshes are area lights; their number is that of the mesh.
    for (size_t i = 0; i < meshes.size(); ++i)
        if (max_component(meshes[i].emission) > 0) {
            py::dict light(py::arg("kind") = "area", py::arg("mesh") = i,
                           py::arg("triangles") = meshes[i].triangles.size(),
                           py::arg("radiance") = array3(meshes[i].emission));
            if (meshes[i].emission_texture >= 0) light["image"] = meshes[i].emission_texture;
            out.append(light);
        }
    for (const SphereLight& l : d.sphere_lights)
        out.append(py::dict(py::arg("kind") = "sphere", py::arg("center") = array3(l.center),
                            py::arg("radius") = l.radius, py::arg("radiance") = array3(l.radiance)));
    if (d.environment) {
        const Environment& e = *d.environment;
        py::dict light(py::arg("kind") = e.image < 0 ? "constant" : "environment",
                       py::arg("scale") = array3(e.scale), py::arg("to_world") = affine_rows(e.to_world));
        if (e.image >= 0) light["image"] = e.image;
        out.append(light);
    }
    return out;
}

}  // namespace viscache::bindings

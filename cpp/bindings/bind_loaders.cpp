// Scene files, and read-only views of a SceneDescription for tests and `info`.
#include <pybind11/stl.h>

#include "arrays.h"
#include "viscache/scene/load.h"

namespace viscache::bindings {

namespace {

using Class = py::class_<SceneDescription>;

py::list mesh_list(const SceneDescription& d) {
    py::list out;
    for (const Mesh& m : d.meshes)
        out.append(py::dict(py::arg("name") = m.name, py::arg("n_vertices") = m.vertices.size(),
                            py::arg("n_triangles") = m.triangles.size(), py::arg("material") = m.material,
                            py::arg("emission") = array3(m.emission),
                            py::arg("emits_two_sided") = m.emits_two_sided, py::arg("in_world") = m.in_world,
                            py::arg("has_normals") = !m.normals.empty(),
                            py::arg("has_uvs") = !m.uvs.empty()));
    return out;
}

py::dict mesh_arrays(const SceneDescription& d, size_t index) {
    const Mesh& m = d.meshes.at(index);
    py::array_t<uint32_t> triangles({py::ssize_t(m.triangles.size()), py::ssize_t(3)});
    if (!m.triangles.empty())
        std::memcpy(triangles.mutable_data(), m.triangles.data(), m.triangles.size() * sizeof(Vec3u));
    py::array_t<float> uvs({py::ssize_t(m.uvs.size()), py::ssize_t(2)});
    if (!m.uvs.empty()) std::memcpy(uvs.mutable_data(), m.uvs.data(), m.uvs.size() * sizeof(Vec2));
    return py::dict(py::arg("vertices") = from_vec3s(m.vertices), py::arg("triangles") = triangles,
                    py::arg("normals") = from_vec3s(m.normals), py::arg("uvs") = uvs);
}

py::list material_list(const SceneDescription& d) {
    py::list out;
    for (const Material& m : d.materials)
        out.append(py::dict(py::arg("kind") = m.kind, py::arg("base_color") = array3(m.base_color),
                            py::arg("specular") = array3(m.specular), py::arg("roughness") = m.roughness,
                            py::arg("eta") = m.eta, py::arg("two_sided") = m.two_sided,
                            py::arg("base_texture") = m.base_texture,
                            py::arg("alpha_texture") = m.alpha_texture,
                            py::arg("alpha_cutoff") = m.alpha_cutoff));
    return out;
}

py::list camera_list(const SceneDescription& d) {
    py::list out;
    for (const Camera& c : d.cameras)
        out.append(py::dict(py::arg("name") = c.name, py::arg("origin") = array3(c.origin),
                            py::arg("right") = array3(c.right), py::arg("up") = array3(c.up),
                            py::arg("forward") = array3(c.forward),
                            py::arg("fov_deg") = c.fov_y_rad * 180.f / kPi,
                            py::arg("horizontal") = c.fov_is_horizontal, py::arg("width") = c.width,
                            py::arg("height") = c.height));
    return out;
}

py::list affine_rows(const Affine& t) {
    py::list rows;
    for (const auto& row : t.m) rows.append(py::cast(row));
    return rows;
}

py::list light_list(const SceneDescription& d) {
    py::list out;
    for (const PointLight& l : d.point_lights)
        out.append(py::dict(py::arg("kind") = "point", py::arg("position") = array3(l.position),
                            py::arg("intensity") = array3(l.intensity)));
    for (const DirectionalLight& l : d.directional_lights)
        out.append(py::dict(py::arg("kind") = "directional", py::arg("direction") = array3(l.direction),
                            py::arg("irradiance") = array3(l.irradiance)));
    for (const SphereLight& l : d.sphere_lights)
        out.append(py::dict(py::arg("kind") = "sphere", py::arg("center") = array3(l.center),
                            py::arg("radius") = l.radius, py::arg("radiance") = array3(l.radiance)));
    for (size_t i = 0; i < d.meshes.size(); ++i)
        if (max_component(d.meshes[i].emission) > 0)
            out.append(py::dict(py::arg("kind") = "area", py::arg("mesh") = i,
                                py::arg("radiance") = array3(d.meshes[i].emission)));
    if (d.environment)
        out.append(py::dict(py::arg("kind") = "environment", py::arg("scale") = array3(d.environment->scale),
                            py::arg("image") = d.environment->image,
                            py::arg("to_world") = affine_rows(d.environment->to_world)));
    return out;
}

py::array_t<float> image_pixels(const SceneDescription& d, size_t index) {
    const Image& i = d.images.at(index);
    py::array_t<float> a({py::ssize_t(i.height), py::ssize_t(i.width), py::ssize_t(i.channels)});
    if (!i.pixels.empty()) std::memcpy(a.mutable_data(), i.pixels.data(), i.pixels.size() * sizeof(float));
    return a;
}

}  // namespace

void bind_loaders(py::module_& m) {
    m.def("load_scene_file", &load_scene_file, py::arg("path"), py::arg("strict") = false,
          py::call_guard<py::gil_scoped_release>(),
          "Read a scene file (.obj .ply .gltf .glb .xml .pbrt .serialized); SceneError says what cannot be "
          "used.");

    auto cls = py::reinterpret_borrow<Class>(m.attr("SceneDescription"));
    cls.def_property_readonly("triangle_count", &count_placed_triangles, "Placed triangles.")
        .def(
            "bounds",
            [](const SceneDescription& d) {
                const Bounds b = placed_bounds(d);
                return std::pair(array3(b.lo), array3(b.hi));
            },
            "Lowest and highest corner of the placed meshes and the sphere lights.")
        .def_property_readonly("meshes", &mesh_list, "Facts of every mesh, as dicts.")
        .def("mesh_arrays", &mesh_arrays, py::arg("index"), "vertices, triangles, normals, uvs of one mesh.")
        .def_property_readonly("materials", &material_list, "Every material, as dicts.")
        .def_property_readonly("cameras", &camera_list, "Every camera, as dicts.")
        .def_property_readonly("lights", &light_list, "Every light, as dicts.")
        .def_property_readonly(
            "instances",
            [](const SceneDescription& d) {
                py::list out;
                for (const Instance& i : d.instances)
                    out.append(py::dict(py::arg("meshes") = i.meshes,
                                        py::arg("to_world") = affine_rows(i.to_world)));
                return out;
            },
            "Every instance, as dicts.")
        .def("image_pixels", &image_pixels, py::arg("index"), "Linear pixels (H, W, C) of a decoded image.");
}

}  // namespace viscache::bindings

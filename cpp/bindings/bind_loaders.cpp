// Scene files, and read-only views of a SceneDescription for tests and `info`.
#include "described.h"
#include "gil.h"
#include "viscache/formats/load.h"

namespace viscache::bindings {

namespace {

using Class = py::class_<SceneDescription>;

py::list mesh_list(const SceneDescription& d) {
    py::list out;
    for (const Mesh& m : d.meshes)
        out.append(py::dict(py::arg("name") = m.name, py::arg("n_vertices") = m.vertices.size(),
                            py::arg("n_triangles") = m.triangles.size(), py::arg("material") = m.material,
                            py::arg("emission") = array3(m.emission),
                            py::arg("emission_texture") = m.emission_texture,
                            py::arg("emits_two_sided") = m.emits_two_sided, py::arg("in_world") = m.in_world,
                            py::arg("has_normals") = !m.normals.empty(), py::arg("has_uvs") = !m.uvs.empty(),
                            py::arg("has_colors") = !m.colors.empty()));
    return out;
}

py::dict mesh_arrays(const SceneDescription& d, size_t index) {
    const Mesh& m = d.meshes.at(index);
    py::array_t<float> uvs({py::ssize_t(m.uvs.size()), py::ssize_t(2)});
    if (!m.uvs.empty()) std::memcpy(uvs.mutable_data(), m.uvs.data(), m.uvs.size() * sizeof(Vec2));
    return py::dict(py::arg("vertices") = from_vec3s(m.vertices),
                    py::arg("triangles") = from_triangles(m.triangles),
                    py::arg("normals") = from_vec3s(m.normals), py::arg("uvs") = uvs,
                    py::arg("colors") = linear_colors(m.colors));
}

py::list material_list(const SceneDescription& d) {
    py::list out;
    for (const Material& m : d.materials) out.append(material_dict(m));
    return out;
}

py::list camera_list(const SceneDescription& d) {
    py::list out;
    for (const Camera& c : d.cameras)
        out.append(
            py::dict(py::arg("name") = c.name, py::arg("origin") = array3(c.origin),
                     py::arg("right") = array3(c.right), py::arg("up") = array3(c.up),
                     py::arg("forward") = array3(c.forward), py::arg("fov_deg") = c.fov_y_rad * 180.f / kPi,
                     py::arg("horizontal") = c.fov_is_horizontal, py::arg("view_height") = c.view_height,
                     py::arg("shift") = std::array{c.shift_x, c.shift_y}, py::arg("width") = c.width,
                     py::arg("height") = c.height));
    return out;
}

}  // namespace

void bind_loaders(py::module_& m) {
    m.def(
        "load_scene_file",
        [](const std::string& path, bool strict, bool skip_missing, bool allow_outside, Point origin) {
            return load_scene_file(path, {strict, skip_missing, allow_outside, origin});
        },
        py::arg("path"), py::arg("strict") = false, py::arg("skip_missing") = false,
        py::arg("allow_outside") = false, py::arg("origin") = Point{}, py::call_guard<WithoutGil>(),
        "Read a scene file (.obj .ply .gltf .glb .xml .pbrt .serialized); SceneError says what cannot be "
        "used.");

    // The class is bound in bind_description.cpp; this file adds what only reads.
    auto cls = py::reinterpret_borrow<Class>(m.attr("SceneDescription"));
    cls.def_property_readonly("triangle_count", &count_placed_triangles, "Placed triangles.")
        .def(
            "bounds",
            [](const SceneDescription& d) {
                const Bounds b = placed_bounds(d);
                return std::pair(array3(b.lo), array3(b.hi));
            },
            "Lowest and highest corner of the placed meshes and the sphere lights.")
        .def_property_readonly("meshes", &mesh_list, "A dict per mesh, without its arrays.")
        .def("mesh_arrays", &mesh_arrays, py::arg("index"),
             "vertices, triangles, normals, uvs, linear colors of one mesh.")
        .def_property_readonly("materials", &material_list, "A dict per material.")
        .def_property_readonly("cameras", &camera_list, "A dict per camera.")
        .def_property_readonly(
            "lights", [](const SceneDescription& d) { return light_dicts(d, d.meshes); }, "A dict per light.")
        .def_property_readonly(
            "instances",
            [](const SceneDescription& d) {
                py::list out;
                for (const Instance& i : d.instances)
                    out.append(py::dict(py::arg("meshes") = i.meshes,
                                        py::arg("to_world") = affine_rows(i.to_world)));
                return out;
            },
            "A dict per instance.")
        .def(
            "image_pixels",
            [](const SceneDescription& d, size_t index) { return pixels_of(d.images.at(index)); },
            py::arg("index"), "Linear pixels (H, W, C) of a decoded image.");
}

}  // namespace viscache::bindings

// What a frozen scene holds, as plain Python objects.
#include <pybind11/stl.h>

#include <fstream>

#include "arrays.h"
#include "viscache/scene/content_hash.h"
#include "viscache/scene/decode_image.h"
#include "viscache/scene/scene.h"

namespace viscache::bindings {

namespace {

py::dict mesh_dict(const Scene& scene, size_t index) {
    if (index >= scene.described_meshes())
        throw py::index_error("mesh must be in [0, " + std::to_string(scene.described_meshes()) + "), got " +
                              std::to_string(index));
    const Mesh& mesh = scene.meshes()[index];
    py::dict d;
    d["name"] = mesh.name, d["vertices"] = from_vec3s(mesh.vertices);
    py::array_t<uint32_t> triangles({py::ssize_t(mesh.triangles.size()), py::ssize_t(3)});
    if (!mesh.triangles.empty())
        std::memcpy(triangles.mutable_data(), mesh.triangles.data(), mesh.triangles.size() * sizeof(Vec3u));
    d["triangles"] = triangles, d["normals"] = from_vec3s(mesh.normals);
    d["material"] = mesh.material, d["emission"] = array3(mesh.emission), d["in_world"] = mesh.in_world;
    return d;
}

py::list lights_list(const Scene& scene) {
    const SceneDescription& d = scene.description();
    py::list out;
    for (const PointLight& l : d.point_lights)
        out.append(py::dict(py::arg("kind") = "point", py::arg("position") = array3(l.position),
                            py::arg("intensity") = array3(l.intensity)));
    for (const DirectionalLight& l : d.directional_lights)
        out.append(py::dict(py::arg("kind") = "directional", py::arg("direction") = array3(l.direction),
                            py::arg("irradiance") = array3(l.irradiance)));
    for (size_t i = 0; i < scene.described_meshes(); ++i)
        if (const Mesh& mesh = scene.meshes()[i]; max_component(mesh.emission) > 0)
            out.append(py::dict(py::arg("kind") = "area", py::arg("mesh") = i,
                                py::arg("triangles") = mesh.triangles.size(),
                                py::arg("radiance") = array3(mesh.emission)));
    for (const SphereLight& l : d.sphere_lights)
        out.append(py::dict(py::arg("kind") = "sphere", py::arg("center") = array3(l.center),
                            py::arg("radius") = l.radius, py::arg("radiance") = array3(l.radiance)));
    if (d.environment)
        out.append(py::dict(py::arg("kind") = d.environment->image < 0 ? "constant" : "environment",
                            py::arg("scale") = array3(d.environment->scale)));
    return out;
}

}  // namespace

void bind_scene_info(py::module_& m) {
    m.def("scene_mesh", &mesh_dict, py::arg("scene"), py::arg("index"), "Arrays of one mesh.");
    m.def("scene_mesh_count", &Scene::described_meshes, py::arg("scene"));
    m.def("scene_lights", &lights_list, py::arg("scene"));
    m.def(
        "scene_materials",
        [](const Scene& s) {
            py::list out;
            for (const Material& m : std::span(s.materials()).first(s.described_materials()))
                out.append(py::dict(py::arg("kind") = m.kind, py::arg("base_color") = array3(m.base_color),
                                    py::arg("specular") = array3(m.specular),
                                    py::arg("roughness") = m.roughness, py::arg("eta") = m.eta,
                                    py::arg("two_sided") = m.two_sided));
            return out;
        },
        py::arg("scene"));
    m.def(
        "scene_instances",
        [](const Scene& s) {
            py::list out;
            for (const Instance& i : s.description().instances)
                out.append(py::make_tuple(i.meshes, py::array_t<double>({3, 4}, &i.to_world.m[0][0])));
            return out;
        },
        py::arg("scene"), "(meshes, to_world (3, 4)) of every instance.");
    m.def(
        "scene_warnings",
        [](const Scene& s) {
            std::vector<std::pair<std::string, std::string>> out;
            for (const Warning& w : s.description().warnings) out.emplace_back(w.where, w.text);
            return out;
        },
        py::arg("scene"));
    m.def(
        "description_of",
        [](const Scene& s) {
            SceneDescription d = s.description();
            d.meshes.resize(s.described_meshes()), d.materials.resize(s.described_materials());
            return d;
        },
        py::arg("scene"), "A copy that can be changed.");
    m.def(
        "read_image",
        [](const std::string& path) {
            std::ifstream file(path, std::ios::binary);
            if (!file) throw SceneError(path + ": no such file, or it cannot be read");
            const std::string bytes{std::istreambuf_iterator<char>(file), {}};
            const Image image = loading::decode_image(bytes, path, true);
            py::array_t<float> pixels(
                {py::ssize_t(image.height), py::ssize_t(image.width), py::ssize_t(image.channels)});
            std::memcpy(pixels.mutable_data(), image.pixels.data(), image.pixels.size() * sizeof(float));
            return pixels;
        },
        py::arg("path"), "Linear pixels (H, W, C) of a .hdr, .png or .jpg file.");
    m.def("scene_hash", [](const Scene& s) { return content_hash(s.description()); }, py::arg("scene"));
}

}  // namespace viscache::bindings

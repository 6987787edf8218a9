// The contents of a frozen scene as plain Python objects.
#include "described.h"
#include "gil.h"
#include "viscache/formats/decode_image.h"
#include "viscache/scene/content_hash.h"
#include "viscache/scene/scene.h"

namespace viscache::bindings {

namespace {

py::dict mesh_dict(const Scene& scene, size_t index) {
    if (index >= scene.described_meshes())
        throw py::index_error("mesh must be in [0, " + std::to_string(scene.described_meshes()) + "), got " +
                              std::to_string(index));
    const Mesh& mesh = scene.meshes()[index];
    using namespace py::literals;
    return py::dict("name"_a = mesh.name, "vertices"_a = from_vec3s(mesh.vertices),
                    "triangles"_a = from_triangles(mesh.triangles), "normals"_a = from_vec3s(mesh.normals),
                    "colors"_a = linear_colors(mesh.colors), "material"_a = mesh.material,
                    "emission"_a = array3(mesh.emission), "in_world"_a = mesh.in_world);
}

}  // namespace

void bind_scene_info(py::module_& m) {
    m.def("scene_mesh", &mesh_dict, py::arg("scene"), py::arg("index"), "Arrays of one mesh.");
    m.def("scene_mesh_count", &Scene::described_meshes, py::arg("scene"));
    m.def(
        "scene_lights",
        [](const Scene& s) {
            // Freezing appends the meshes of sphere lights, which nobody has described.
            return light_dicts(s.description(), std::span(s.meshes()).first(s.described_meshes()));
        },
        py::arg("scene"));
    m.def(
        "scene_materials",
        [](const Scene& s) {
            py::list out;
            for (const Material& m : std::span(s.materials()).first(s.described_materials()))
                out.append(material_dict(m));
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
            // What freezing has appended is appended again when the description is frozen.
            d.meshes.resize(s.described_meshes());
            d.materials.resize(s.described_materials());
            return d;
        },
        py::arg("scene"), "A description of the scene that can be changed.");
    m.def(
        "read_image",
        [](const std::string& path) {
            Image image;
            // A file is read and decoded without the lock; the array is made with it.
            {
                const WithoutGil release;
                image = loading::decode_image(loading::read_file(path), path, true);
            }
            return pixels_of(image);
        },
        py::arg("path"), "Linear pixels (H, W, C) of a PNG, JPEG, HDR, TGA or BMP file.");
    m.def("scene_hash", [](const Scene& s) { return content_hash(s.description()); }, py::arg("scene"));
    m.def("scene_offset_extent", &Scene::offset_extent, py::arg("scene"),
          "The length that scales the offsets of ray origins.");
    m.def(
        "scene_sphere",
        [](const Scene& s) {
            const Vec3 c = s.center();
            return std::array<float, 4>{c.x, c.y, c.z, s.radius()};
        },
        py::arg("scene"), "Bounding sphere: centre and radius.");
    m.def("geometry_hash", [](const Scene& s) { return geometry_hash(s.description()); }, py::arg("scene"));
}

}  // namespace viscache::bindings

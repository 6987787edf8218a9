#include "viscache/scene/face_colors.h"

#include <bit>
#include <unordered_map>

namespace viscache {

void color_faces(Mesh& mesh, std::span<const VertexColor> faces) {
    if (faces.size() != mesh.triangles.size())
        throw SceneError("colours of faces must be one per triangle (" +
                         std::to_string(mesh.triangles.size()) + "), got " + std::to_string(faces.size()));
    std::vector<char> used(mesh.vertices.size(), 0);
    std::unordered_map<uint64_t, uint32_t> copies;  // by vertex and colour
    mesh.colors.assign(mesh.vertices.size(), {});
    for (size_t i = 0; i < mesh.triangles.size(); ++i) {
        const VertexColor color = faces[i];
        Vec3u& t = mesh.triangles[i];
        for (uint32_t* corner : {&t.x, &t.y, &t.z}) {
            const uint32_t v = *corner;
            if (v >= used.size())
                throw SceneError("triangle " + std::to_string(i) + " names vertex " + std::to_string(v) +
                                 ", but there are " + std::to_string(used.size()) + " vertices");
            if (!used[v]) {
                used[v] = 1;
                mesh.colors[v] = color;
            }
            if (mesh.colors[v] == color) continue;
            const uint64_t key = uint64_t(v) << 32 | std::bit_cast<uint32_t>(color);
            const auto [found, is_new] = copies.try_emplace(key, uint32_t(mesh.vertices.size()));
            if (is_new) {
                if (found->second == 0xffffffffu)
                    throw SceneError("a mesh must have at most 2^32 - 1 vertices");
                mesh.vertices.push_back(Vec3(mesh.vertices[v]));
                if (!mesh.normals.empty()) mesh.normals.push_back(Vec3(mesh.normals[v]));
                if (!mesh.uvs.empty()) mesh.uvs.push_back(Vec2(mesh.uvs[v]));
                mesh.colors.push_back(color);
            }
            *corner = found->second;
        }
    }
}

}  // namespace viscache

#pragma once
// A scene of a few triangles with lights, for tests of whole frames.
#include "viscache/casters/bsp_caster.h"
#include "viscache/scene/scene.h"

namespace viscache::test {

inline void add_quad(SceneDescription& d, Vec3 corner, Vec3 a, Vec3 b, int material, Rgb emission = {}) {
    Mesh mesh;
    mesh.vertices = {corner, corner + a, corner + a + b, corner + b};
    mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
    mesh.material = material;
    mesh.emission = emission;
    d.meshes.push_back(std::move(mesh));
}

/// A floor and a board above it, with two lamps, a sun and a small area light.
inline std::shared_ptr<const Scene> lit_board() {
    SceneDescription d;
    d.materials.push_back({.base_color = {0.6f, 0.5f, 0.4f}});
    add_quad(d, {-2, 0, -2}, {0, 0, 4}, {4, 0, 0}, 0);
    add_quad(d, {-0.5f, 0.5f, -0.5f}, {1, 0, 0}, {0, 0, 1}, 0);
    add_quad(d, {-1.5f, 2, -0.2f}, {0.4f, 0, 0}, {0, 0, 0.4f}, 0, {5, 5, 5});
    d.point_lights.push_back({{1.5f, 1, 1}, {2, 2, 2}});
    d.point_lights.push_back({{-0.3f, 1.2f, 0.4f}, {1, 2, 1}});
    d.directional_lights.push_back({normalize(Vec3{0.3f, 1, 0.2f}), {0.5f, 0.5f, 0.5f}});
    return Scene::freeze(std::move(d));
}

}  // namespace viscache::test

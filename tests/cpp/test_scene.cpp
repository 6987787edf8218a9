// scene/camera.h: the frame of the pinhole camera. scene/description_bytes.h: conversion to bytes and back.
#include "check.h"
#include "viscache/scene/camera.h"
#include "viscache/scene/content_hash.h"
#include "viscache/scene/description_bytes.h"

namespace viscache::test::scene_tests {
namespace {

void cameras_have_orthonormal_frames() {
    const Vec3 origin{1, 2, 3};
    for (Vec3 target :
         {Vec3{4, 5, 6}, Vec3{1, 9, 3}, Vec3{1, -9, 3}, Vec3{1, 2, -4}}) {  // two look along `up`
        const Camera c = look_at(origin, target, {0, 1, 0}, 1.f);
        check_near(length(c.right), 1, 1e-6, "|right|");
        check_near(length(c.up), 1, 1e-6, "|up|");
        check_near(dot(c.right, c.up), 0, 1e-6, "right · up");
        check_near(dot(c.right, c.forward), 0, 1e-6, "right · forward");
        check_near(dot(c.forward, normalize(target - origin)), 1, 1e-6, "forward points at the target");
        check_near(dot(cross(c.right, c.up), c.forward), -1, 1e-6, "right × up points against forward");
    }
}

SceneDescription of_everything() {
    SceneDescription d;
    d.name = "everything";
    Mesh mesh;
    mesh.name = "one";
    mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    mesh.triangles = {{0, 1, 2}};
    mesh.normals = {{0, 0, 1}, {0, 0, 1}, {0, 0, 1}};
    mesh.uvs = {{0, 0}, {1, 0}, {0, 1}};
    mesh.colors = {{1, 2, 3, 4}, {}, {}};
    mesh.emission = {1, 2, 3};
    mesh.in_world = false;
    d.meshes = {mesh};
    d.instances = {{{0}, {}}, {{0}, {}}};
    d.materials = {{MaterialKind::kGlossy}};
    d.images = {{"a.png", "a.xml:3", false, 1, 1, 3, {0.1f, 0.2f, 0.3f}}};
    d.point_lights = {{{1, 2, 3}, {4, 5, 6}}};
    d.directional_lights = {{{0, 1, 0}, {1, 1, 1}}};
    d.sphere_lights = {{{0, 5, 0}, 0.5f, {9, 9, 9}}};
    d.environment = Environment{{1, 1, 1}, 0, {}};
    d.cameras = {look_at({0, 0, 5}, {0, 0, 0}, {0, 1, 0}, 1.f)};
    d.warnings = {{"a.xml:4", "is not modelled"}};
    return d;
}

void descriptions_come_back_from_bytes() {
    const SceneDescription given = of_everything();
    const std::string bytes = description_bytes(given);
    const SceneDescription found = description_from(bytes);
    check(content_hash(found) == content_hash(given), "everything that decides how a scene looks comes back");
    check(description_bytes(found).size() == bytes.size(), "and everything else");
    check(found.name == given.name && found.images[0].where == "a.xml:3" &&
              found.warnings[0].text == "is not modelled" && found.cameras[0].width == 640,
          "names, places and warnings come back");
    const SceneDescription none = description_from(description_bytes({}));
    check(none.meshes.empty() && !none.environment, "an empty description comes back");
}

void damaged_bytes_are_refused() {
    const std::string bytes = description_bytes(of_everything());
    const auto refused = [](const std::string& text) {
        try {
            description_from(text);
        } catch (const SceneError&) {
            return true;
        }
        return false;
    };
    for (size_t n = 0; n < bytes.size(); n += 7)
        check(refused(bytes.substr(0, n)), "bytes that end too early are refused");
    check(refused(bytes + "x"), "bytes that are left over are refused");
    check(refused(std::string(16, '\xff')), "other bytes are refused");
}

const Suite suite{
    {"camera: frames are orthonormal, also when looking along up", cameras_have_orthonormal_frames},
    {"description: comes back from its bytes", descriptions_come_back_from_bytes},
    {"description: damaged bytes are refused", damaged_bytes_are_refused}};

}  // namespace
}  // namespace viscache::test::scene_tests

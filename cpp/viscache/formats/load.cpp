#include "viscache/formats/load.h"

#include <filesystem>

#include "viscache/formats/allowed_files.h"
#include "viscache/formats/decode_image.h"
#include "viscache/formats/loading.h"

namespace viscache {

namespace {

using ReadFunction = void (*)(const std::string&, loading::Loading&);

ReadFunction reader_for(const std::string& path) {
    const std::string extension = loading::extension_of(path);
    if (extension == ".obj") return loading::load_obj;
    if (extension == ".ply") return loading::load_ply;
    if (extension == ".xml") return loading::load_mitsuba;
    if (extension == ".pbrt") return loading::load_pbrt;
    if (extension == ".gltf" || extension == ".glb") return loading::load_gltf;
    if (extension == ".serialized") return loading::load_serialized;
    loading::fail(path, "unknown scene format '" + extension +
                            "'; known are .obj .ply .gltf .glb .xml (Mitsuba) .pbrt .serialized");
}

// Sums of light that contain one infinity or NaN would spread it over whole frames.
void check_loaded_lights(const SceneDescription& s, const std::string& path) {
    for (const PointLight& l : s.point_lights)
        if (!is_finite(l.position) || !is_finite(l.intensity))
            loading::fail(path, "a point light is not finite");
    for (const DirectionalLight& l : s.directional_lights)
        if (!is_finite(l.direction) || !is_finite(l.irradiance) || length2(l.direction) == 0)
            loading::fail(path, "a directional light is not finite or has no direction");
    for (const SphereLight& l : s.sphere_lights)
        if (!is_finite(l.center) || !is_finite(l.radiance) || !(l.radius > 0) || !std::isfinite(l.radius))
            loading::fail(path, "a sphere light is not finite or has no radius");
    if (s.environment && !is_finite(s.environment->scale))
        loading::fail(path, "the environment is not finite");
}

void check_cameras(const SceneDescription& s, const std::string& path) {
    for (const Camera& c : s.cameras) {
        const bool ok = is_finite(c.origin) && is_finite(c.right) && is_finite(c.up) &&
                        is_finite(c.forward) && c.fov_y_rad > 0 && c.fov_y_rad < kPi;
        if (!ok)
            loading::fail(path,
                          "camera '" + c.name + "' is not finite or its field of view is not in (0, 180)");
        if (c.width < 1 || c.height < 1 || c.width > 1 << 16 || c.height > 1 << 16)
            loading::fail(path, "camera '" + c.name + "' asks for " + std::to_string(c.width) + " x " +
                                    std::to_string(c.height) + " pixels; both must be in [1, 65536]");
    }
}

void make_printable(SceneDescription& s) {
    for (Mesh& mesh : s.meshes) mesh.name = loading::printable(std::move(mesh.name));
    for (Camera& camera : s.cameras) camera.name = loading::printable(std::move(camera.name));
    for (Image& image : s.images) image.where = loading::printable(std::move(image.where));
    for (Warning& w : s.warnings) {
        w.where = loading::printable(std::move(w.where));
        w.text = loading::printable(std::move(w.text));
    }
}

}  // namespace

SceneDescription load_scene_file(const std::string& path, const LoadOptions& options) {
    SceneDescription scene;
    scene.name = std::filesystem::path(path).stem().string();
    loading::Loading state(scene, options.strict, options.skip_missing);
    state.origin = options.origin;
    // In force while this object lives: a scene must not read files of the machine that are not part of it.
    const loading::AllowedFiles allowed(path, options.allow_outside);
    try {
        reader_for(path)(path, state);
        set_origin(scene, options.origin);
        check_loaded_lights(scene, path);
        check_cameras(scene, path);
        // Last of the work: a scene that cannot be used fails before its pictures are read.
        loading::decode_images(state);
        state.count_warnings();
        // Last, since images and warnings are still added above. Python refuses strings that are not UTF-8.
        make_printable(scene);
    } catch (const std::bad_alloc&) {
        loading::fail(path, "not enough memory");
    } catch (const SceneError&) {
        throw;
    } catch (const std::exception& error) {
        // A library or a container rejected a size or an index of the file that the checks above did not
        // catch.
        loading::fail(path, std::string("the file is broken (") + error.what() + ")");
    }
    return scene;
}

void set_origin(SceneDescription& scene, const Point& origin) {
    const Point by{origin[0] - scene.origin[0], origin[1] - scene.origin[1], origin[2] - scene.origin[2]};
    // A loader that placed everything relative to the origin itself has nothing left to move.
    if (by == Point{}) return;
    const auto move = [&](Vec3& p) { p = {float(p.x - by[0]), float(p.y - by[1]), float(p.z - by[2])}; };
    for (Instance& instance : scene.instances)
        for (size_t i = 0; i < 3; ++i) instance.to_world.m[i][3] -= by[i];
    for (Mesh& mesh : scene.meshes)
        if (mesh.in_world)
            for (Vec3& p : mesh.vertices) move(p);
    for (PointLight& light : scene.point_lights) move(light.position);
    for (SphereLight& light : scene.sphere_lights) move(light.center);
    for (Camera& camera : scene.cameras) move(camera.origin);
    scene.origin = origin;
}

uint64_t count_placed_triangles(const SceneDescription& scene) {
    uint64_t n = 0;
    for (const Mesh& mesh : scene.meshes) n += mesh.in_world ? mesh.triangles.size() : 0;
    for (const Instance& instance : scene.instances)
        for (int i : instance.meshes) n += scene.meshes.at(size_t(i)).triangles.size();
    return n;
}

Bounds placed_bounds(const SceneDescription& scene) {
    Bounds box;
    for (const Mesh& mesh : scene.meshes)
        if (mesh.in_world)
            for (Vec3 p : mesh.vertices) box.add(p);
    for (const Instance& instance : scene.instances)
        for (int i : instance.meshes)
            for (Vec3 p : scene.meshes.at(size_t(i)).vertices) box.add(instance.to_world.point(p));
    for (const SphereLight& light : scene.sphere_lights) {
        const Vec3 r{light.radius, light.radius, light.radius};
        box.add(light.center - r);
        box.add(light.center + r);
    }
    return box;
}

}  // namespace viscache

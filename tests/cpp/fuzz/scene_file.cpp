// libFuzzer: a scene file of one format is loaded, or refused with a SceneError. What is loaded is finite and
// passes the checks that a scene is built with.
// VISCACHE_FUZZ_FORMAT: obj, ply, serialized, gltf, glb, pbrt or xml; mtl: the materials of an OBJ file.
#include <cmath>
#include <cstdint>
#include <new>
#include <string>

#include "input_file.h"
#include "viscache/formats/load.h"
#include "viscache/scene/check.h"

namespace viscache::fuzz {
namespace {

const std::string kFormat = VISCACHE_FUZZ_FORMAT;

const std::string& scene_path() {
    static const std::string path = input_path(kFormat == "mtl" ? "obj" : kFormat);
    static const bool written =
        kFormat != "mtl" ||
        write_file(path, "mtllib " + name_of(input_path("mtl")) +
                             "\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nusemtl a\nf 1/1 2/1 3/1\n"
                             "usemtl b\nf 1 3 2\n");
    if (!written) std::abort();
    return path;
}

void load(std::string_view content) {
    const std::string& path = scene_path();
    if (!write_file(input_path(kFormat), content)) std::abort();
    const SceneDescription scene = load_scene_file(path);
    check_description(scene);
    for (const auto& mesh : scene.meshes)
        for (const Vec3& v : mesh.vertices)
            if (!(std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z))) std::abort();
    const Bounds bounds = placed_bounds(scene);
    if (count_placed_triangles(scene) > 0 && !(bounds.lo.x <= bounds.hi.x)) std::abort();
}

}  // namespace
}  // namespace viscache::fuzz

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    try {
        viscache::fuzz::load({reinterpret_cast<const char*>(data), size});
    } catch (const viscache::SceneError&) {
    } catch (const std::bad_alloc&) {
    }
    return 0;
}

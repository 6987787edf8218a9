#pragma once
// Scene files: OBJ, PLY, glTF 2.0 / GLB, Mitsuba XML and pbrt-v3 text, each to a SceneDescription.
#include <cstdint>
#include <string>

#include "viscache/math/bounds.h"
#include "viscache/scene/description.h"

namespace viscache {

/// Reads the scene in `path`; the extension chooses the format (.obj .ply .gltf .glb .xml .pbrt .serialized).
/// PNG, JPEG, TGA, BMP and HDR images are decoded; EXR entries stay pending (width 0).
/// What the file asks for that is not modelled is named in `warnings`; with `strict` it is a SceneError.
/// Throws SceneError (file, place, what was found) for anything that cannot be used.
SceneDescription load_scene_file(const std::string& path, bool strict = false);

/// Triangles as placed in the world: instances count once for each placement.
uint64_t count_placed_triangles(const SceneDescription& scene);

/// Box around the placed meshes and the sphere lights.
Bounds placed_bounds(const SceneDescription& scene);

}  // namespace viscache

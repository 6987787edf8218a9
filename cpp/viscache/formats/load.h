#pragma once
// Loads scene files (OBJ, PLY, glTF 2.0 / GLB, Mitsuba XML, pbrt text) into a SceneDescription.
#include <cstdint>
#include <string>

#include "viscache/math/bounds.h"
#include "viscache/scene/description.h"

namespace viscache {

struct LoadOptions {
    bool strict = false;         ///< features that are not modelled are errors
    bool skip_missing = false;   ///< shapes whose file is not there are left out with a warning
    bool allow_outside = false;  ///< files outside of the scene's folder may be read (allowed_files.h)
    Point origin{};              ///< becomes the scene's origin
};

/// Reads the scene file `path`. The extension selects the format (.obj .ply .gltf .glb .xml .pbrt
/// .serialized). PNG, JPEG, TGA, BMP and HDR images are decoded; EXR images stay pending (width 0). Features
/// that are not modelled are listed in `warnings`. Throws SceneError (file, place, what was found) for
/// content that cannot be used.
SceneDescription load_scene_file(const std::string& path, const LoadOptions& options = {});

/// Makes another point of the world the origin of a loaded scene: what is placed moves, in double precision.
/// Meshes of instances do not stand in the world themselves.
void set_origin(SceneDescription& scene, const Point& origin);

/// Number of triangles placed in the world; a mesh counts once for each instance.
uint64_t count_placed_triangles(const SceneDescription& scene);

/// Bounding box of the placed meshes and the sphere lights.
Bounds placed_bounds(const SceneDescription& scene);

}  // namespace viscache

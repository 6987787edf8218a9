#pragma once
// All placed triangles of a scene as one list in world space, for structures without instances.
#include <vector>

#include "viscache/scene/scene.h"

namespace viscache {

/// Source of a triangle of the list, as in `Hit`.
struct TriangleSource {
    uint32_t mesh, triangle;
    uint32_t instance;  ///< kNoHit: not instanced
};

struct FlatTriangle {
    Vec3 a, b, c;
    Bounds bounds() const { return {min(min(a, b), c), max(max(a, b), c)}; }
};

struct FlatTriangles {
    std::vector<FlatTriangle> triangles;
    std::vector<TriangleSource> sources;  ///< one per triangle
    uint64_t degenerate = 0;              ///< triangles without area, left out because no ray can hit them
    Bounds bounds;
};

/// Triangles of the world's meshes in order (tessellated sphere lights last), then those of every instance,
/// transformed as by `Scene::surface`. Throws std::length_error for 2^32 - 1 triangles or more.
FlatTriangles flat_triangles(const Scene& scene);

/// What structures subtract from coordinates to keep digits. Along an axis it is the middle of the scene if
/// the scene is far from the origin, otherwise 0. Differences to it are exact, because all coordinates are
/// within a factor of two of each other.
Vec3 exact_origin(const Bounds& bounds);

}  // namespace viscache

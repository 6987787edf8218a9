#pragma once
// Rays that see area lights alone: the lights that directions drawn by the BRDF find.
#include <optional>

#include "viscache/scene/scene.h"
#include "viscache/visibility/query.h"

namespace viscache {

/// A point on an area light.
struct EmitterHit {
    size_t light;  ///< over triangles, then spheres
    Vec3 point;
    Vec3 normal;   ///< unit; on the emitting side, or for two-sided triangles on the side of the ray
    Vec2 weights;  ///< barycentric weights of a triangle's vertices b and c
};

/// Whether `nearest_emitter` can return the light. Lights with holes are not found, because they do not hide
/// others.
bool can_be_hit(const AreaLights& lights, size_t light);

/// The nearest light of those that can be hit. Its emitting side may face away. The direction of the ray is
/// a unit vector.
std::optional<EmitterHit> nearest_emitter(const Scene& scene, const Ray& ray);

}  // namespace viscache

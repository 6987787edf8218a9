#pragma once
// The surface that a ray has hit.
#include "viscache/scene/scene.h"
#include "viscache/visibility/ray_caster.h"

namespace viscache {

inline SurfacePoint surface_at(const Scene& scene, const Ray& ray, const Hit& hit) {
    const int instance = hit.instance == kNoHit ? -1 : int(hit.instance);
    return scene.surface(hit.mesh, hit.triangle, instance, hit.u, hit.v, &ray.o, &ray.d);
}

/// Origin of a ray that leaves the surface on a side, given by the unit normal.
inline Vec3 spawn(const SurfacePoint& s, Vec3 side) { return spawn(s.position, side, s.extent); }

}  // namespace viscache

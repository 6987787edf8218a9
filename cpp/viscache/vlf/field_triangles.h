#pragma once
// The triangles of a field: data for the kernels, and the source of each triangle.
#include <memory>
#include <span>
#include <vector>

#include "viscache/casters/flat_triangles.h"
#include "viscache/casters/triangle_kernels.h"
#include "viscache/scene/scene.h"
#include "viscache/vlf/tile_walk.h"

namespace viscache {

/// A ray as the kernels take it: it starts near the scene and is relative to `FieldTriangles::origin`.
struct LocalRay {
    Ray ray;
    double shift = 0;  ///< the caller's t is the local t plus this
};

class FieldTriangles {
public:
    /// Fits the unit ball around the triangles; its radius is `head_room` times theirs.
    FieldTriangles(std::shared_ptr<const Scene> scene, TriangleKernel kernel, double head_room);

    const Scene& scene() const { return *scene_; }
    const FieldSpace& space() const { return space_; }
    size_t size() const { return sources_.size(); }
    uint64_t degenerate() const { return degenerate_; }
    /// The triangles in the unit ball, for building subfields.
    std::span<const FlatTriangle> in_ball() const { return in_ball_; }
    uint64_t bytes() const;

    /// Rays that start far away are moved close to the scene: coordinates of thousands of radii would leave
    /// the kernels too little precision.
    LocalRay to_local(const Ray& ray, const FieldRay& in_ball) const;
    /// Nearest hit of the listed triangles, if it is nearer than `best`.
    template <class Kernel>
    void nearest(const Kernel& kernel, std::span<const uint32_t> ids, NearestHit& best) const {
        for (const uint32_t id : ids) {
            TriangleHit hit;
            // The alpha mask is looked up last, for hits that would win.
            if (kernel(id, best.t, hit) && best.nearer(hit, id) && (!cutouts_ || solid(id, hit)))
                best.take(hit, id);
        }
    }
    /// True if a ray hits any of the listed triangles before `limit`.
    template <class Kernel>
    bool any(const Kernel& kernel, std::span<const uint32_t> ids, float limit) const {
        for (const uint32_t id : ids) {
            TriangleHit hit;
            if (kernel(id, limit, hit) && hit.t < limit && (!cutouts_ || solid(id, hit))) return true;
        }
        return false;
    }
    /// Calls work(kernel) with the kernel of this field, set up for a ray.
    template <class Work>
    auto with_kernel(const Ray& local, Work work) const {
        if (kernel_ == TriangleKernel::kWald)
            return work([&](uint32_t id, float limit, TriangleHit& hit) {
                return intersect_wald(wald_[id], local, limit, hit);
            });
        // The shear depends only on the ray and serves all of its triangles.
        const ShearedRay sheared(local);
        return work([&](uint32_t id, float limit, TriangleHit& hit) {
            return intersect_watertight(corners_[id], sheared, limit, hit);
        });
    }
    /// True if a triangle, given in scene space, lies in the ball.
    bool holds(const FlatTriangle& world) const;
    /// Adds ids for triangles that are set later.
    void grow(size_t count);
    void set(uint32_t id, const FlatTriangle& world);
    /// Converts a hit in the scene to the result for the caller.
    Hit hit(const NearestHit& best) const;

private:
    bool solid(uint32_t id, const TriangleHit& hit) const {
        const TriangleSource& from = sources_[id];
        return from.mesh == kNoHit || scene_->solid_at(from.mesh, from.triangle, hit.u, hit.v);
    }
    void fit(const std::vector<FlatTriangle>& triangles, const Bounds& bounds, double head_room);
    Vec3 to_ball(Vec3 p) const;

    std::shared_ptr<const Scene> scene_;
    TriangleKernel kernel_;
    FieldSpace space_;
    Vec3 origin_;  ///< origin of the triangle data; nonzero only for scenes far from the origin
    uint64_t degenerate_ = 0;
    bool cutouts_ = false;
    std::vector<TriangleSource> sources_;
    std::vector<FlatTriangle> in_ball_;
    std::vector<WaldTriangle> wald_;  ///< only the data of the chosen kernel is stored
    std::vector<WatertightTriangle> corners_;
};

}  // namespace viscache

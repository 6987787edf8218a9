#pragma once
// The triangles of a field: records for the kernels, and where each of them comes from.
#include <memory>
#include <span>
#include <vector>

#include "viscache/scene/scene.h"
#include "viscache/visibility/flat_triangles.h"
#include "viscache/visibility/triangle_kernels.h"
#include "viscache/vlf/tile_walk.h"

namespace viscache {

/// A ray as the kernels get it: near the scene and relative to `FieldTriangles::origin`.
struct LocalRay {
    Ray ray;
    double shift = 0;  ///< the caller's t is the local one plus this
};

class FieldTriangles {
public:
    /// Fits the unit ball around the triangles, `head_room` times as large.
    FieldTriangles(std::shared_ptr<const Scene> scene, TriangleKernel kernel, double head_room);

    const Scene& scene() const { return *scene_; }
    const FieldSpace& space() const { return space_; }
    size_t size() const { return sources_.size(); }
    uint64_t degenerate() const { return degenerate_; }
    /// In the unit ball, for building subfields.
    std::span<const FlatTriangle> in_ball() const { return in_ball_; }
    uint64_t bytes() const;

    /// Rays that start far off are moved to where they come near: coordinates of thousands of radii leave
    /// the kernels no digits.
    LocalRay to_local(const Ray& ray, const FieldRay& in_ball) const;
    /// Nearest of the triangles listed, if nearer than `best`.
    template <class Kernel>
    void nearest(const Kernel& kernel, std::span<const uint32_t> ids, NearestHit& best) const {
        for (const uint32_t id : ids) {
            TriangleHit hit;
            if (kernel(id, best.t, hit) && best.nearer(hit, id) && (!cutouts_ || solid(id, hit)))
                best.take(hit, id);
        }
    }
    /// Whether a ray hits any of the triangles listed before `limit`.
    template <class Kernel>
    bool any(const Kernel& kernel, std::span<const uint32_t> ids, float limit) const {
        for (const uint32_t id : ids) {
            TriangleHit hit;
            if (kernel(id, limit, hit) && hit.t < limit && (!cutouts_ || solid(id, hit))) return true;
        }
        return false;
    }
    /// Calls work(kernel) with the kernel of this field and a ray.
    template <class Work>
    auto with_kernel(const Ray& local, Work work) const {
        if (kernel_ == TriangleKernel::kWald)
            return work([&](uint32_t id, float limit, TriangleHit& hit) {
                return intersect_wald(wald_[id], local, limit, hit);
            });
        const ShearedRay sheared(local);
        return work([&](uint32_t id, float limit, TriangleHit& hit) {
            return intersect_watertight(corners_[id], sheared, limit, hit);
        });
    }
    /// Whether a triangle of the scene's space lies in the ball.
    bool holds(const FlatTriangle& world) const;
    /// Adds ids for triangles that `set` is to give.
    void grow(size_t count);
    void set(uint32_t id, const FlatTriangle& world);
    /// What a caller gets, of a hit in the scene.
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
    Vec3 origin_;  ///< of the records; not zero only for scenes far from the origin
    uint64_t degenerate_ = 0;
    bool cutouts_ = false;
    std::vector<TriangleSource> sources_;
    std::vector<FlatTriangle> in_ball_;
    std::vector<WaldTriangle> wald_;  ///< of one kernel the records are there
    std::vector<WatertightTriangle> corners_;
};

}  // namespace viscache

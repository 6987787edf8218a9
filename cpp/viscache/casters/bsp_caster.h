#pragma once
// A single-ray tracer over a BSP with axis-aligned planes: the baseline of the paper on the visibility
// field.
#include <memory>
#include <vector>

#include "viscache/casters/bsp_tree.h"
#include "viscache/scene/scene.h"
#include "viscache/visibility/ray_caster.h"

namespace viscache {

/// Statistics of a build.
struct BspStats {
    uint64_t triangles = 0, degenerate = 0;
    uint64_t nodes = 0, leaves = 0, empty_leaves = 0, references = 0;
    int max_depth = 0, depth = 0;  ///< the limit, and the depth reached
    uint64_t bytes = 0;            ///< tree and triangle data
};

/// Totals of what rays visited.
struct BspSteps {
    uint64_t nodes = 0, leaves = 0, tests = 0;
    void node() { ++nodes; }
    void leaf(uint32_t count) {
        ++leaves;
        tests += count;
    }
};

/// [VLF Sec. 5.1] The single-ray BSP tracer. Cells are halved in the middle of their longest side up to a
/// maximum depth. Rays are traced front to back with a stack. Triangles are stored in Wald's layout.
///
/// The hits are those of its triangle kernel; they may differ from Embree's within rounding error of an
/// edge.
class BspCaster final : public RayCaster {
public:
    /// Throws std::invalid_argument, or OverBudget for a tree larger than `settings.max_bytes`.
    BspCaster(std::shared_ptr<const Scene> scene, const BspSettings& settings, int threads, Control& control);
    void intersect(std::span<const Ray> rays, std::span<Hit> hits, Coherence) const override;
    void occluded(std::span<const Ray> rays, std::span<uint8_t> occluded) const override;
    uint16_t occluded16(uint16_t mask, RayPacket16& rays, Coherence coherence) const override;

    const Scene& scene() const { return *scene_; }
    const BspStats& stats() const { return stats_; }
    /// Counts nodes, leaves and triangle tests for the nearest hits of some rays, traced one by one.
    BspSteps count_steps(std::span<const Ray> rays) const;

private:
    Hit nearest(const Ray& ray) const;
    bool any(const Ray& ray) const;
    template <class Leaf, class OnNode>
    void walk(const Ray& local, float limit, OnNode on_node, Leaf leaf) const;
    template <class Kernel, class Steps>
    NearestHit nearest_in(const Kernel& kernel, const Ray& local, Steps& steps) const;
    template <class Kernel>
    bool any_in(const Kernel& kernel, const Ray& local) const;
    bool solid(uint32_t id, const TriangleHit& hit) const;
    Ray to_local(const Ray& ray) const { return {ray.o - origin_, ray.t_min, ray.d, ray.t_max}; }
    void place_records(std::span<const FlatTriangle> triangles);
    void count_nodes();

    std::shared_ptr<const Scene> scene_;
    TriangleKernel kernel_;
    BspTree tree_;
    Vec3 origin_;       ///< subtracted from rays and triangles; nonzero only far from the origin
    float extent_ = 0;  ///< largest coordinate after the subtraction
    bool cutouts_ = false;
    std::vector<TriangleSource> sources_;
    std::vector<WaldTriangle> wald_;  ///< only the data of the chosen kernel is stored
    std::vector<WatertightTriangle> corners_;
    BspStats stats_;
};

}  // namespace viscache

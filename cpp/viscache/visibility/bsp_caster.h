#pragma once
// Single rays through a BSP with axis-aligned planes: the tracer the visibility field's paper compares with.
#include <memory>
#include <vector>

#include "viscache/scene/scene.h"
#include "viscache/visibility/bsp_tree.h"
#include "viscache/visibility/ray_caster.h"

namespace viscache {

/// What building left behind.
struct BspStats {
    uint64_t triangles = 0, degenerate = 0;
    uint64_t nodes = 0, leaves = 0, empty_leaves = 0, references = 0;
    int max_depth = 0, depth = 0;  ///< the limit, and the depth reached
    uint64_t bytes = 0;            ///< tree and triangle records
};

/// What rays met on their way, summed.
struct BspSteps {
    uint64_t nodes = 0, leaves = 0, tests = 0;
    void node() { ++nodes; }
    void leaf(uint32_t count) { ++leaves, tests += count; }
};

/// [VLF Sec. 5.1] The single-ray BSP tracer: cells halved at the middle of their longest side down to a
/// depth, front to back with a stack of its own, triangles in Wald's layout.
///
/// Its hits are those of its triangle kernel, which may differ from Embree's within rounding of an edge.
class BspCaster final : public RayCaster {
public:
    /// Throws std::invalid_argument, or OverBudget for a tree larger than `settings.max_bytes`.
    BspCaster(std::shared_ptr<const Scene> scene, const BspSettings& settings, int threads, Control& control);
    void intersect(std::span<const Ray> rays, std::span<Hit> hits, Coherence) const override;
    void occluded(std::span<const Ray> rays, std::span<uint8_t> occluded) const override;
    uint16_t occluded16(uint16_t mask, RayPacket16& rays, Coherence coherence) const override;

    const Scene& scene() const { return *scene_; }
    const BspStats& stats() const { return stats_; }
    /// Nodes, leaves and triangle tests of the nearest hits of some rays, one by one.
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
    Vec3 origin_;       ///< rays and triangles are moved by it: not zero only far from the origin
    float extent_ = 0;  ///< largest coordinate after that
    bool cutouts_ = false;
    std::vector<TriangleSource> sources_;
    std::vector<WaldTriangle> wald_;  ///< of one kernel the records are there
    std::vector<WatertightTriangle> corners_;
    BspStats stats_;
};

}  // namespace viscache

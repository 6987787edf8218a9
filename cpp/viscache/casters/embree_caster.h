#pragma once
// Exact rays by Embree.
#include <memory>
#include <span>
#include <string>

#include "viscache/casters/ray_arrays.h"
#include "viscache/math/bits.h"
#include "viscache/scene/scene.h"
#include "viscache/visibility/ray_caster.h"

namespace viscache {

class RayBatch;

struct EmbreeOptions {
    /// Watertight at edges, with the same answer on every ISA; costs 15–35 %.
    bool robust = true;
};

class EmbreeCaster final : public RayCaster {
public:
    explicit EmbreeCaster(std::shared_ptr<const Scene> scene, EmbreeOptions options = {});
    ~EmbreeCaster() override;
    void intersect(std::span<const Ray> rays, std::span<Hit> hits, Coherence coherence) const override;
    void occluded(std::span<const Ray> rays, std::span<uint8_t> occluded) const override;
    uint16_t occluded16(uint16_t mask, RayPacket16& rays, Coherence coherence) const override;
    Coherence flag_for(float width) const override {
        return width <= coherent_width_ ? Coherence::kCoherent : Coherence::kIncoherent;
    }
    /// Boxes of instances have axes of their own, so any segment may lie along one of their faces.
    Coherence flag_of_segments() const override {
        return scene_->description().instances.empty() ? Coherence::kCoherent : Coherence::kIncoherent;
    }
    /// Any hit of checked rays, in packets of 8 or 16. Stores the answer of ray i in blocked[i]; `blocked`
    /// has room for RayBatch::kMost.
    void occluded(const RayBatch& batch, uint8_t* blocked, const PacketPlan& plan) const;
    /// The same for rays [first, first + count) of arrays, which are not checked, in a plain loop: the
    /// baseline. Stores the answer of ray k in occluded[k].
    void occluded_in_a_loop(const RayArrays& rays, size_t first, size_t count, uint8_t* occluded,
                            const PacketPlan& plan) const;
    /// Traces one ray per point along an axis or against it, on the side of the point's normal (n·axis = 0:
    /// along). Stores the blocked lanes, 16 bits per packet. For plans of width 8 and 16.
    void blocked_along(const PointLanes& points, Vec3 axis, float t_max, uint16_t* blocked,
                       const PacketPlan& plan) const;
    /// Traces the rays of one point along all axes in the same way. Stores words_for(axes) words of bits.
    void blocked_from(Vec3 origin, Vec3 normal, const AxisLanes& axes, float t_max, Word* blocked,
                      const PacketPlan& plan) const;
    /// Nearest hits with one Embree call per ray, as a baseline for single-ray tracers.
    void intersect_singly(std::span<const Ray> rays, std::span<Hit> hits) const;
    const Scene& scene() const { return *scene_; }
    /// True if Embree supports packets of 16 on this CPU (AVX-512). Otherwise 16 rays are traced as two
    /// packets of 8.
    bool native16() const;
    static std::string version();

private:
    struct Impl;
    std::shared_ptr<const Scene> scene_;
    std::unique_ptr<Impl> impl_;
    float coherent_width_;  ///< half diagonal up to which coherent traversal is the faster one
};

}  // namespace viscache

#pragma once
// Exact rays by Embree.
#include <memory>
#include <span>
#include <string>

#include "viscache/math/bits.h"
#include "viscache/scene/scene.h"
#include "viscache/visibility/ray_arrays.h"
#include "viscache/visibility/ray_caster.h"

namespace viscache {

struct EmbreeOptions {
    /// Watertight edges, the same answer from every ISA; costs 15–35 %.
    bool robust = true;
};

class EmbreeCaster final : public RayCaster {
public:
    explicit EmbreeCaster(std::shared_ptr<const Scene> scene, EmbreeOptions options = {});
    ~EmbreeCaster() override;
    void intersect(std::span<const Ray> rays, std::span<Hit> hits, Coherence coherence) const override;
    void occluded(std::span<const Ray> rays, std::span<uint8_t> occluded) const override;
    uint16_t occluded16(uint16_t mask, RayPacket16& rays, Coherence coherence) const override;
    /// Any hit of rays [first, first + count); the answer of ray k goes to occluded[k].
    void occluded(const RayArrays& rays, size_t first, size_t count, uint8_t* occluded,
                  const PacketPlan& plan) const;
    /// The same of the rays numbered in `order`, one after another.
    void occluded(const RayArrays& rays, std::span<const uint32_t> order, uint8_t* occluded,
                  const PacketPlan& plan) const;
    /// Every point's ray along an axis or against it, on the side of its normal (n·axis = 0: along): the
    /// lanes blocked, 16 bits per packet. Plans of width 8 and 16.
    void blocked_along(const PointLanes& points, Vec3 axis, float t_max, uint16_t* blocked,
                       const PacketPlan& plan) const;
    /// One point's rays along all axes, the same way: bits, words_for(axes) words.
    void blocked_from(Vec3 origin, Vec3 normal, const AxisLanes& axes, float t_max, Word* blocked,
                      const PacketPlan& plan) const;
    /// Nearest hits by one call of Embree per ray: what single-ray tracers are compared with.
    void intersect_singly(std::span<const Ray> rays, std::span<Hit> hits) const;
    const Scene& scene() const { return *scene_; }
    /// True if Embree has packets of 16 on this CPU (AVX-512); else 16 rays go as two packets of 8.
    bool native16() const;
    static std::string version();

private:
    struct Impl;
    std::shared_ptr<const Scene> scene_;
    std::unique_ptr<Impl> impl_;
};

}  // namespace viscache

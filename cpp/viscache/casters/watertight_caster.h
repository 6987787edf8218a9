#pragma once
// Embree finds the candidates, our own watertight test decides.
#include <memory>
#include <span>

#include "viscache/scene/scene.h"
#include "viscache/visibility/ray_caster.h"

namespace viscache {

/// Rays that pass neither edges nor vertices, at Embree's speed of descent.
///
/// Embree's own triangle test misses some rays that aim exactly at a vertex. Here Embree holds boxes of
/// triangles alone, grown by more than all rounding, and asks `intersect_watertight` about every triangle
/// whose box a ray meets. The hits are those of `BspCaster` with its watertight kernel, and the same on every
/// instruction set. Instances are stored as copies, as in our other structures.
class WatertightCaster final : public RayCaster {
public:
    /// Throws std::length_error for 2^32 - 1 placed triangles or more, and std::bad_alloc.
    explicit WatertightCaster(std::shared_ptr<const Scene> scene);
    ~WatertightCaster() override;
    void intersect(std::span<const Ray> rays, std::span<Hit> hits, Coherence) const override;
    void occluded(std::span<const Ray> rays, std::span<uint8_t> occluded) const override;
    uint16_t occluded16(uint16_t mask, RayPacket16& rays, Coherence) const override;
    const Scene& scene() const { return *scene_; }

private:
    struct Impl;
    std::shared_ptr<const Scene> scene_;
    std::unique_ptr<Impl> impl_;
};

}  // namespace viscache

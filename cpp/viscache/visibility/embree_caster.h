#pragma once
// Exact rays by Embree.
#include <memory>
#include <string>

#include "viscache/scene/scene.h"
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
    void intersect(std::span<const Ray> rays, std::span<Hit> hits) const override;
    void occluded(std::span<const Ray> rays, std::span<uint8_t> occluded) const override;
    uint16_t occluded16(uint16_t mask, RayPacket16& rays, Coherence coherence) const override;
    const Scene& scene() const { return *scene_; }
    /// Bare loop over rtcOccluded1/4/8/16 with rays copied from arrays: the baseline of `viscache bench rays`.
    void bare_occluded(std::span<const Ray> rays, std::span<uint8_t> occluded, int width) const;
    static std::string version();

private:
    struct Impl;
    std::shared_ptr<const Scene> scene_;
    std::unique_ptr<Impl> impl_;
};

}  // namespace viscache

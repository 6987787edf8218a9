#pragma once
// Exact rays by Embree.
#include <array>
#include <memory>
#include <span>
#include <string>

#include "viscache/scene/scene.h"
#include "viscache/visibility/ray_caster.h"

namespace viscache {

struct EmbreeOptions {
    /// Watertight edges, the same answer from every ISA; costs 15–35 %.
    bool robust = true;
};

/// Rays as arrays, read in place: ray i = origin[i] + t·direction[i] for t in [0, t_max[i·t_stride]].
struct RayArrays {
    const Vec3* origin;
    const Vec3* direction;
    const float* t_max;
    size_t t_stride;  ///< 0: one t_max for all
};

/// How rays are handed to Embree. Speed only: in robust scenes every plan gives the same answers.
struct PacketPlan {
    int width = 8;  ///< 1, 4, 8 or 16
    Coherence coherence = Coherence::kIncoherent;
};

/// Chooses a plan by timing some plans on a share of the rays. One object per thread and batch of alike rays.
class PacketTrial {
public:
    /// Plans for this CPU; a batch of few rays is not worth a trial and goes by the first.
    explicit PacketTrial(bool native16, bool worth_it = true);
    /// True if the next chunk should try all plans; counts the chunk.
    bool due() { return worth_it_ && chunks_++ % kPeriod == 0; }
    std::span<const PacketPlan> plans() const { return plans_; }
    const PacketPlan& best() const { return plans_[best_]; }
    /// Takes the seconds each plan spent on equal shares of a chunk.
    void learn(std::span<const double> seconds);

private:
    static constexpr size_t kPeriod = 32;
    std::array<PacketPlan, 3> plans_;
    size_t best_ = 0, chunks_ = 0;
    bool worth_it_;
};

class EmbreeCaster final : public RayCaster {
public:
    explicit EmbreeCaster(std::shared_ptr<const Scene> scene, EmbreeOptions options = {});
    ~EmbreeCaster() override;
    void intersect(std::span<const Ray> rays, std::span<Hit> hits) const override;
    void occluded(std::span<const Ray> rays, std::span<uint8_t> occluded) const override;
    uint16_t occluded16(uint16_t mask, RayPacket16& rays, Coherence coherence) const override;
    /// Any hit of rays [first, first + occluded.size()).
    void occluded(const RayArrays& rays, size_t first, std::span<uint8_t> occluded,
                  const PacketPlan& plan) const;
    /// The same by the plan that the trial finds fastest.
    void occluded(const RayArrays& rays, size_t first, std::span<uint8_t> occluded, PacketTrial& trial) const;
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

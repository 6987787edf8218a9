#pragma once
// The interface for the question "which rays hit, and where?". Exact up to float rounding.
#include <cstdint>
#include <span>

#include "viscache/visibility/query.h"

namespace viscache {

/// Sixteen rays as arrays. Lanes outside the mask of a call are ignored but must be finite.
struct alignas(64) RayPacket16 {
    float ox[16], oy[16], oz[16], t_min[16];
    float dx[16], dy[16], dz[16], t_max[16];

    void start(size_t lane, Vec3 o) {
        ox[lane] = o.x;
        oy[lane] = o.y;
        oz[lane] = o.z;
    }
    /// Sets (dx, dy, dz): a direction, or an end point that is not a direction yet.
    void aim(size_t lane, Vec3 d) {
        dx[lane] = d.x;
        dy[lane] = d.y;
        dz[lane] = d.z;
    }
    void set(size_t lane, const Ray& ray) {
        start(lane, ray.o);
        aim(lane, ray.d);
        t_min[lane] = ray.t_min;
        t_max[lane] = ray.t_max;
    }
    Ray ray(size_t i) const { return {{ox[i], oy[i], oz[i]}, t_min[i], {dx[i], dy[i], dz[i]}, t_max[i]}; }
};

/// Coherent traversal suits consecutive rays with similar origins and ends. Answers do not change, with two
/// exceptions: among several hits at equal distance, the nearest can be a different one; and one any-hit
/// answer in 10⁹ is rounded differently (docs/performance/exact.md). So the choice is never timed: the same
/// rays are traced in the same way in every run.
enum class Coherence { kIncoherent, kCoherent };

constexpr uint32_t kNoHit = 0xffffffffu;

struct Hit {
    float t = kInfinity;
    uint32_t mesh = kNoHit;      ///< index into the meshes of the Scene; kNoHit: no hit
    uint32_t triangle = kNoHit;  ///< index inside that mesh
    uint32_t instance = kNoHit;  ///< kNoHit: not instanced
    float u = 0, v = 0;          ///< barycentric coordinates of vertices 1 and 2
    bool valid() const { return mesh != kNoHit; }
};

/// Rays must be finite, with components below kMaxCoordinate in size and t_min >= 0 (`check_rays` tests user
/// input). Everything built from a Scene satisfies this.
class RayCaster {
public:
    virtual ~RayCaster() = default;
    /// Nearest hit of every ray.
    virtual void intersect(std::span<const Ray> rays, std::span<Hit> hits, Coherence coherence) const = 0;
    /// Any hit: sets occluded[i] to 1 or 0.
    virtual void occluded(std::span<const Ray> rays, std::span<uint8_t> occluded) const = 0;
    /// Any hit of the lanes in `mask`. Returns the mask of occluded lanes. `rays` may be overwritten.
    virtual uint16_t occluded16(uint16_t mask, RayPacket16& rays, Coherence coherence) const = 0;
    /// The faster traversal of 16 rays to one point or along one direction, where the bounding box of their
    /// origins has this half diagonal (packet_choice.h).
    virtual Coherence flag_for(float) const { return Coherence::kIncoherent; }
    /// The traversal of packets of segments between any two points that gives the answers of single rays
    /// (segment_packets.h).
    virtual Coherence flag_of_segments() const { return Coherence::kCoherent; }
};

}  // namespace viscache

#pragma once
// Takes rays from a caller's arrays in batches: checked and arranged in lanes, before any of them is traced.
#include <cstdint>
#include <span>

#include "viscache/casters/ray_arrays.h"
#include "viscache/math/isa.h"
#include "viscache/visibility/ray_caster.h"

namespace viscache {

/// Rows, ends and lanes of some packets of 16 rays.
struct RayLanes {
    static constexpr size_t kPackets = 16;
    RayPacket16 packet[kPackets];
    alignas(
        64) int32_t asked[kPackets][16];  ///< −1, or 0 for a ray that hits nothing: empty or without length
};

/// One batch of rays; reuses its memory from batch to batch.
class RayBatch {
public:
    static constexpr size_t kMost = 16 * RayLanes::kPackets;  // fits into the first cache

    explicit RayBatch(Isa isa = active_isa());
    /// Takes the rays [first, first + count), at most kMost. False if one of them must not be traced: a
    /// component that is not finite or above kMaxCoordinate in size, or a t_max that is not >= 0.
    bool take(const RayArrays& rays, size_t first, size_t count);
    /// Takes the rays with the indices in `order`.
    bool take(const RayArrays& rays, std::span<const uint32_t> order);

    size_t size() const { return size_; }
    /// Ray i is lane i % 16 of packet i / 16. Lanes past the end are copies that are not asked.
    const RayLanes& lanes() const { return lanes_; }

    /// What a kernel reads: rows without gaps.
    struct Input {
        const float *origin, *direction, *t_max;
        size_t t_step;  ///< floats from the ends of one packet to those of the next
    };

private:
    using Pack = bool (*)(const Input&, size_t, RayLanes&);
    template <class Number>
    bool gather(const RayArrays& rays, Number number, size_t count);
    bool pack(const Input& input, size_t count);

    Pack pack_;
    size_t size_ = 0;
    RayLanes lanes_;
    alignas(64) float origin_[3 * kMost], direction_[3 * kMost], t_max_[kMost];
};

}  // namespace viscache

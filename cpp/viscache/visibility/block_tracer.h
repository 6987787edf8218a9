#pragma once
// Traces any-hit rays of a caller's arrays, block by block, in the way that suits them. Affects speed only:
// in robust scenes every way gives the same answers.
#include <cstdint>
#include <optional>

#include "viscache/visibility/embree_caster.h"
#include "viscache/visibility/ray_batch.h"
#include "viscache/visibility/ray_order.h"

namespace viscache {

/// Ways to trace a block of rays.
enum class RayWay {
    kCoherent,  ///< as given, in coherent packets
    kAsGiven,   ///< as given, in incoherent packets
    kSorted,    ///< similar rays together, in incoherent packets
};

/// One object per thread. The way of a block follows from its rays and its scene, never from time.
class BlockTracer {
public:
    /// The answer for ray k is stored in occluded[k]. `fixed`: always use this way.
    BlockTracer(const EmbreeCaster& caster, const RayArrays& rays, uint8_t* occluded,
                std::optional<RayWay> fixed = {});
    /// Traces rays [first, first + count). Stops at the first batch with a ray that must not be traced, and
    /// returns false. Nothing of such a batch is traced.
    bool block(size_t first, size_t count);

private:
    RayWay way_of(size_t first, size_t count);

    const EmbreeCaster& caster_;
    RayArrays rays_;
    uint8_t* occluded_;
    std::optional<RayWay> fixed_;
    RayOrder order_;
    RayBatch batch_;
};

}  // namespace viscache

#pragma once
// Sorts rays so that consecutive rays have similar origins and directions and their packets traverse the
// same part of the scene. Affects speed only.
#include <cstdint>
#include <span>
#include <vector>

#include "viscache/casters/ray_arrays.h"
#include "viscache/math/isa.h"

namespace viscache {

/// Orders blocks of rays by classes of similar rays; reuses its memory from block to block. Rays that must
/// not be traced do no harm here.
class RayOrder {
public:
    /// Cells of the box of a block's origins.
    struct Cells {
        Vec3 lo, scale;
    };

    explicit RayOrder(Isa isa = active_isa());
    /// Fraction of the rays [first, first + count) in the same class as the ray before them, from a sample of
    /// some hundred rays. Near 1 for rays of neighbouring pixels, near 0 for rays in no order.
    double share_in_order(const RayArrays& rays, size_t first, size_t count);
    /// Indices of the rays [first, first + count), class by class; the order within a class is kept. Valid
    /// until the next call.
    std::span<const uint32_t> sort(const RayArrays& rays, size_t first, size_t count);

private:
    using Classify = void (*)(const Cells&, const float*, const float*, size_t, uint16_t*);
    void classify(const RayArrays& rays, const Cells& cells, size_t first, size_t count, size_t at);

    Classify classify_;
    std::vector<uint16_t> class_;
    std::vector<uint32_t> order_, begin_;
};

}  // namespace viscache

#pragma once
// Sorts rays so that consecutive rays have similar origins and directions and their packets traverse the
// same part of the scene. Affects speed only.
#include <cstdint>
#include <span>
#include <vector>

#include "viscache/visibility/ray_arrays.h"

namespace viscache {

/// Sorts blocks of rays; reuses its memory from block to block.
class RayOrder {
public:
    /// Computes the class of each of the rays [first, first + count).
    void classify(const RayArrays& rays, size_t first, size_t count);
    /// Fraction of the classified rays in the same class as the ray before them. Near 1 for rays of
    /// neighbouring pixels, near 0 for rays in no order.
    double share_in_order() const;
    /// Indices of the classified rays, class by class; the order within a class is kept. Valid until the
    /// next call.
    std::span<const uint32_t> sort();

private:
    size_t first_ = 0;
    std::vector<uint16_t> class_;
    std::vector<uint32_t> order_, begin_;
};

}  // namespace viscache

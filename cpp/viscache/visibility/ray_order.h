#pragma once
// An order of rays in which neighbours start near each other and go the same way, so that packets of
// neighbours walk the same part of the scene. Speed only.
#include <cstdint>
#include <span>
#include <vector>

#include "viscache/visibility/ray_arrays.h"

namespace viscache {

/// Sorts blocks of rays; keeps its memory from block to block.
class RayOrder {
public:
    /// Looks at rays [first, first + count): which class each belongs to.
    void classify(const RayArrays& rays, size_t first, size_t count);
    /// Share of the classified rays that belong to the class of the ray before them. Rays of neighbouring
    /// pixels come near 1; rays in no order near 0.
    double share_in_order() const;
    /// Numbers of the classified rays, class by class, as given inside a class. Valid until the next call.
    std::span<const uint32_t> sort();

private:
    size_t first_ = 0;
    std::vector<uint16_t> class_;
    std::vector<uint32_t> order_, begin_;
};

}  // namespace viscache

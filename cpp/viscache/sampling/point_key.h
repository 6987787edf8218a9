#pragma once
// Random numbers keyed by a place: the same for any division into tiles.
#include <bit>

#include "viscache/sampling/rng.h"

namespace viscache {

/// A key mixed with the bits of a point.
inline uint64_t mix_point(uint64_t key, Vec3 p) {
    key = mix64(key ^ (uint64_t(std::bit_cast<uint32_t>(p.x)) << 32 | std::bit_cast<uint32_t>(p.y)));
    return mix64(key ^ std::bit_cast<uint32_t>(p.z));
}

}  // namespace viscache

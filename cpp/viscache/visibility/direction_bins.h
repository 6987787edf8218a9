#pragma once
// Coarse bins of directions; bins with close numbers contain similar directions.
#include <bit>
#include <cmath>
#include <cstdint>

#include "viscache/math/vec.h"

namespace viscache {

/// Bin of a direction of any length: kEdge × kEdge cells (kEdge is a power of two up to 16) of the
/// octahedral square, along a Morton curve. Branch-free, because random directions would mispredict
/// branches, and without tables, for the compiler's vectors.
template <uint32_t kEdge>
inline __attribute__((always_inline)) uint32_t direction_bin(Vec3 d) {
    const float ax = std::fabs(d.x), ay = std::fabs(d.y);
    const float scale = 1 / (ax + ay + std::fabs(d.z) + 1e-38f);
    const float x = ax * scale, y = ay * scale;
    // One of two numbers by their bits: the compiler would make a branch of a conditional
    const uint32_t below = -uint32_t(d.z < 0);
    const auto fold = [&](float above, float folded) __attribute__((always_inline)) {
        return std::bit_cast<float>((std::bit_cast<uint32_t>(folded) & below) |
                                    (std::bit_cast<uint32_t>(above) & ~below));
    };
    const float u = std::copysign(fold(x, 1 - y), d.x), v = std::copysign(fold(y, 1 - x), d.y);
    const auto spread_cell = [](float s) __attribute__((always_inline)) {
        const float at = (s + 1) * (kEdge / 2);
        const uint32_t c = uint32_t(int32_t(at < kEdge - 1.f ? at : kEdge - 1.f));  // not-a-number: the last
        return (c & 1) | (c & 2) << 1 | (c & 4) << 2 | (c & 8) << 3;
    };
    return spread_cell(u) | spread_cell(v) << 1;
}

}  // namespace viscache

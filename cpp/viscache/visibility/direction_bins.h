#pragma once
// Coarse bins of directions; bins with close numbers contain similar directions.
#include <algorithm>
#include <cmath>
#include <cstdint>

#include "viscache/math/vec.h"

namespace viscache {

/// Bin of a direction of any length: kEdge × kEdge cells (kEdge is a power of two up to 16) of the
/// octahedral square, along a Morton curve. Branch-free, because random directions would mispredict
/// branches.
template <uint32_t kEdge>
uint32_t direction_bin(Vec3 d) {
    constexpr uint32_t kSpread[16] = {0, 1, 4, 5, 16, 17, 20, 21, 64, 65, 68, 69, 80, 81, 84, 85};
    const float ax = std::fabs(d.x), ay = std::fabs(d.y);
    const float scale = 1 / std::max(ax + ay + std::fabs(d.z), 1e-38f);
    const bool below = d.z < 0;
    const float u = std::copysign(below ? 1 - ay * scale : ax * scale, d.x);
    const float v = std::copysign(below ? 1 - ax * scale : ay * scale, d.y);
    const auto cell = [](float s) { return uint32_t(std::min((s + 1) * (kEdge / 2), kEdge - 1.f)); };
    return kSpread[cell(u)] | kSpread[cell(v)] << 1;
}

}  // namespace viscache

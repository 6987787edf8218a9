#pragma once
// Morton (Z-order) codes: points with close codes are close in space.
#include <algorithm>
#include <cstdint>
#include <numeric>
#include <span>
#include <vector>

#include "viscache/math/vec.h"

namespace viscache {

/// Spreads the lowest 10 bits to every third bit.
inline uint32_t spread3(uint32_t v) {
    v &= 0x3ffu;
    // Each step splits groups of bits in two and moves the upper half away, until single bits are three
    // apart: abcd, then ab....cd, then a..b..c..d.
    v = (v | v << 16) & 0x030000ffu;
    v = (v | v << 8) & 0x0300f00fu;
    v = (v | v << 4) & 0x030c30c3u;
    return (v | v << 2) & 0x09249249u;
}

/// Spreads 32 bits to every second bit.
inline uint64_t spread2(uint64_t v) {
    v = (v | v << 16) & 0x0000ffff0000ffffull;
    v = (v | v << 8) & 0x00ff00ff00ff00ffull;
    v = (v | v << 4) & 0x0f0f0f0f0f0f0f0full;
    v = (v | v << 2) & 0x3333333333333333ull;
    return (v | v << 1) & 0x5555555555555555ull;
}
/// Inverse of spreading 16 bits: collects the even bits.
inline uint32_t gather2(uint32_t v) {
    v &= 0x55555555u;
    v = (v | v >> 1) & 0x33333333u;
    v = (v | v >> 2) & 0x0f0f0f0fu;
    v = (v | v >> 4) & 0x00ff00ffu;
    return (v | v >> 8) & 0xffffu;
}

/// [VisMap Eq. 10] Z-order index of a cell of a square map: x on the even bits, y on the odd bits. The cells
/// of a quadtree node are consecutive. `gather2(code)` gives x and `gather2(code >> 1)` gives y.
inline uint32_t morton2(uint32_t x, uint32_t y) { return uint32_t(spread2(x) | spread2(y) << 1); }
/// The same for coordinates of more than 16 bits.
inline uint64_t morton2_wide(uint32_t x, uint32_t y) { return spread2(x) | spread2(y) << 1; }

/// Code of a cell in a grid of 1024³ cells; x is on the lowest bit.
inline uint32_t morton3(uint32_t x, uint32_t y, uint32_t z) {
    return spread3(x) | spread3(y) << 1 | spread3(z) << 2;
}

/// Indices of the points sorted along the Morton curve of their bounding box. The sort is stable: points in
/// the same cell keep their order.
inline std::vector<uint32_t> morton_order(std::span<const Vec3> points) {
    Vec3 lo{kInfinity, kInfinity, kInfinity}, hi{-kInfinity, -kInfinity, -kInfinity};
    for (const Vec3& p : points) {
        lo = {std::min(lo.x, p.x), std::min(lo.y, p.y), std::min(lo.z, p.z)};
        hi = {std::max(hi.x, p.x), std::max(hi.y, p.y), std::max(hi.z, p.z)};
    }
    const auto cell = [](float v, float low, float high) {
        // A flat box has one cell along its flat axis.
        const float share = high > low ? (v - low) / (high - low) : 0.f;
        return share >= 0 ? uint32_t(std::min(1023.f, share * 1024.f)) : 0u;
    };
    std::vector<uint32_t> code(points.size()), order(points.size());
    for (size_t i = 0; i < points.size(); ++i)
        code[i] = morton3(cell(points[i].x, lo.x, hi.x), cell(points[i].y, lo.y, hi.y),
                          cell(points[i].z, lo.z, hi.z));
    std::iota(order.begin(), order.end(), 0u);
    std::stable_sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) { return code[a] < code[b]; });
    return order;
}

}  // namespace viscache

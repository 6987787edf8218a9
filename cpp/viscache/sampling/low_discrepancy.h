#pragma once
// Randomised low-discrepancy points.
#include <cstdint>

#include "viscache/math/vec.h"

namespace viscache {

inline uint32_t reverse_bits(uint32_t x) {
    // Swaps halves, bytes, nibbles, pairs and single bits.
    x = (x << 16) | (x >> 16);
    x = ((x & 0x00ff00ffu) << 8) | ((x & 0xff00ff00u) >> 8);
    x = ((x & 0x0f0f0f0fu) << 4) | ((x & 0xf0f0f0f0u) >> 4);
    x = ((x & 0x33333333u) << 2) | ((x & 0xccccccccu) >> 2);
    return ((x & 0x55555555u) << 1) | ((x & 0xaaaaaaaau) >> 1);
}

/// Hash-based Owen scrambling of a number with its bits in reversed order (Laine and Karras 2011, improved
/// by Vegdahl 2021).
inline uint32_t owen_scramble_reversed(uint32_t x, uint32_t seed) {
    // In reversed order, every step lets a bit depend on itself and lower bits only (products carry upwards).
    // That is Owen's scrambling: a digit is permuted depending on the digits before it.
    x ^= x * 0x3d20adeau;
    x += seed;
    x *= (seed >> 16) | 1u;
    x ^= x * 0x05526c56u;
    x ^= x * 0x53a22864u;
    return reverse_bits(x);
}

/// The same for bits in their usual order.
inline uint32_t owen_scramble(uint32_t x, uint32_t seed) {
    return owen_scramble_reversed(reverse_bits(x), seed);
}

/// A sample's number of its pixel in shuffled order; 0 stays 0. Nested: aligned blocks of 2^k numbers stay
/// together, so the points of a sequence at these numbers are as evenly spread as before.
inline uint32_t shuffled_sample(uint32_t sample, uint32_t shuffle) {
    // Exclusive or keeps the nesting and moves the image of 0 to 0.
    return owen_scramble(sample, shuffle) ^ owen_scramble(0, shuffle);
}

/// The upper 24 bits as a number in [0, 1).
inline float to_unit_float(uint32_t x) { return float(x >> 8) * 0x1p-24f; }

/// Second dimension of the Sobol' sequence at `index`, with its bits reversed. Its matrix is Pascal's
/// triangle mod 2, the fifth Kronecker power of a 2×2 block; five branch-free steps apply it.
inline uint32_t sobol2_reversed(uint32_t index) {
    // Each step adds, at distances 1, 2, 4, 8 and 16, the upper half of every block to its lower half.
    index ^= (index & 0xaaaaaaaau) >> 1;
    index ^= (index & 0xccccccccu) >> 2;
    index ^= (index & 0xf0f0f0f0u) >> 4;
    index ^= (index & 0xff00ff00u) >> 8;
    return index ^ (index & 0xffff0000u) >> 16;
}

/// Point `index` of the (0,2)-sequence (van der Corput and the second Sobol' dimension) in [0, 1)². Each
/// dimension is Owen-scrambled by its own seed.
inline Vec2 sobol02(uint32_t index, uint32_t scramble_x, uint32_t scramble_y) {
    return {to_unit_float(owen_scramble_reversed(index, scramble_x)),
            to_unit_float(owen_scramble_reversed(sobol2_reversed(index), scramble_y))};
}

/// Radical inverse: the digits of i in `base` >= 2, mirrored at the radix point; in [0, 1).
inline double radical_inverse(uint32_t base, uint64_t i) {
    double result = 0, digit = 1.0 / base;
    for (; i; i /= base, digit /= base) result += double(i % base) * digit;
    // Rounding could reach 1.
    return std::min(result, 0x1.fffffffffffffp-1);
}

}  // namespace viscache

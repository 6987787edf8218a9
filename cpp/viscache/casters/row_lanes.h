#pragma once
// Rows of three floats become lanes, in kernels for every instruction set.
#include <cstddef>
#include <cstdint>

namespace viscache {

typedef float RowFour __attribute__((vector_size(16), aligned(4), may_alias));
typedef int32_t RowPlaces __attribute__((vector_size(16)));

/// Four lanes of two vectors, by their places in both.
template <int... kPlaces>
inline __attribute__((always_inline)) RowFour picked_lanes(RowFour a, RowFour b) {
#ifdef __clang__
    return __builtin_shufflevector(a, b, kPlaces...);
#else
    return __builtin_shuffle(a, b, RowPlaces{kPlaces...});
#endif
}

/// Components of 16 rows without gaps: two shuffles of four floats for each component.
inline __attribute__((always_inline)) void rows_to_lanes16(const float* rows, float* __restrict x,
                                                           float* __restrict y, float* __restrict z) {
    for (size_t i = 0; i < 16; i += 4) {
        const RowFour* in = reinterpret_cast<const RowFour*>(rows + 3 * i);
        const RowFour a = in[0], b = in[1], c = in[2];  // xyzx yzxy zxyz
        const RowFour xy = picked_lanes<2, 3, 5, 6>(b, c);
        const RowFour yz = picked_lanes<1, 2, 4, 5>(a, b);
        *reinterpret_cast<RowFour*>(x + i) = picked_lanes<0, 3, 4, 6>(a, xy);
        *reinterpret_cast<RowFour*>(y + i) = picked_lanes<0, 2, 5, 7>(yz, xy);
        *reinterpret_cast<RowFour*>(z + i) = picked_lanes<1, 3, 4, 7>(yz, c);
    }
}

}  // namespace viscache

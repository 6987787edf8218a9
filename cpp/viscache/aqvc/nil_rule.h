#pragma once
// Neighbours that are unknown agree with everything; where many are, agreement says little.
#include <cstddef>

#include "viscache/aqvc/row_kernels.h"
#include "viscache/math/bits.h"

namespace viscache {

/// For a cell that doubts: where two or more of the four neighbours are unknown, the last one becomes a
/// neighbour that disagrees. `room` keeps that neighbour's rows.
inline void doubt_unknown(RowPair own, RowPair neighbours[4], size_t words, BitMatrix& room) {
    room.reset(2, words * 64);
    Word *known = room.row(0), *value = room.row(1);
    for (size_t w = 0; w < words; ++w) {
        const Word a = ~neighbours[0].known[w], b = ~neighbours[1].known[w], c = ~neighbours[2].known[w],
                   d = ~neighbours[3].known[w];
        const Word doubt = (a & b) | (c & d) | ((a | b) & (c | d));
        known[w] = neighbours[3].known[w] | doubt;
        value[w] = (neighbours[3].value[w] & ~doubt) | (~own.value[w] & doubt);
    }
    neighbours[3] = {known, value};
}

}  // namespace viscache

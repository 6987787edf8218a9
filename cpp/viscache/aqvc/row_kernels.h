#pragma once
// Alg. 2 on rows of bits: 512 far ends per step. One variant per instruction set, chosen at run time, same
// bits.
//
// Every row has `words` 64-bit words, a multiple of 8, and starts on a 64-byte boundary.
#include <cstddef>
#include <cstdint>

#include "viscache/math/bits.h"
#include "viscache/math/isa.h"

namespace viscache {

struct RowPair {
    const Word* known;
    const Word* value;
};

struct RowCounts {
    uint64_t lookups = 0, hits = 0, boundary = 0;
};

struct RowKernels {
    /// miss = need & active & ~known, known |= miss; true if a bit of miss is set.
    bool (*take_misses)(const Word* need, const Word* active, Word* known, Word* miss, size_t words);
    /// a &= b.
    void (*keep)(Word* a, const Word* b, size_t words);
    /// disagree &= ~(known & settled).
    void (*drop)(Word* disagree, const Word* known, const Word* settled, size_t words);
    /// Writes the bits of `mask` that are not known below.
    void (*write_down)(const Word* mask, const Word* value, Word* known_below, Word* value_below,
                       size_t words);
    /// disagree = OR_n known_n & (value_n ^ value) | ~known over four neighbours.
    void (*disagreement)(RowPair own, const RowPair neighbours[4], Word* disagree, size_t words);
    /// visible |= a & ~disagree & value; a &= disagree; need |= a. `last_above` counts the bits that go to
    /// the last level.
    void (*settle)(Word* a, RowPair own, const Word* disagree, Word* visible, Word* need, size_t words,
                   bool last_above, RowCounts& counts);
    /// visible |= a & known & value; a &= ~known; true if a bit of a is left.
    bool (*finish)(Word* a, RowPair own, Word* visible, size_t words, RowCounts& counts);
    /// One level of Alg. 2 for one eye point: splits a into misses, settled bits (into visible) and bits that
    /// go on. `last` settles every hit. Returns bit 0: there are misses, bit 1: bits go on.
    int (*step)(Word* a, RowPair own, const RowPair neighbours[4], bool last, Word* miss, Word* visible,
                size_t words, RowCounts& counts);
    uint64_t (*count)(const Word* a, size_t words);
};

/// The variant of `isa`; the one in use is row_kernels(active_isa()).
const RowKernels& row_kernels(Isa isa);

}  // namespace viscache

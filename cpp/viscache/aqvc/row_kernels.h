#pragma once
// Alg. 2 on rows of bits, 512 far ends per step. The variant for the instruction set is chosen at run time;
// all variants give the same bits.
//
// Every row starts on a 64-byte boundary and has `words` 64-bit words, a multiple of 8.
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
    /// miss = need & active & ~known; known |= miss. True if a bit of `miss` is set.
    bool (*take_misses)(const Word* need, const Word* active, Word* known, Word* miss, size_t words);
    /// a &= b.
    void (*keep)(Word* a, const Word* b, size_t words);
    /// disagree &= ~(known & resolved).
    void (*drop)(Word* disagree, const Word* known, const Word* resolved, size_t words);
    /// Copies the bits of `mask` that are unknown at the level below to that level.
    void (*store_below)(const Word* mask, const Word* value, Word* known_below, Word* value_below,
                        size_t words);
    /// Answers bits of one eye point by its own rays: visible = visible & ~mask | mask & value; a &= ~mask.
    /// Bits that were open count as look-ups and hits.
    void (*adopt)(Word* a, const Word* mask, const Word* value, Word* visible, size_t words,
                  RowCounts& counts);
    /// disagree = OR_n known_n & (value_n ^ value) | ~known, over the four neighbours n.
    void (*disagreement)(RowPair own, const RowPair neighbours[4], Word* disagree, size_t words);
    /// visible |= a & ~disagree & value; a &= disagree; need |= a. With `last_above`, counts the bits that go
    /// on to the last level.
    void (*resolve)(Word* a, RowPair own, const Word* disagree, Word* visible, Word* need, size_t words,
                    bool last_above, RowCounts& counts);
    /// visible |= a & known & value; a &= ~known. True if a bit of `a` is left.
    bool (*finish)(Word* a, RowPair own, Word* visible, size_t words, RowCounts& counts);
    /// One level of Alg. 2 for one eye point. Splits `a` into misses, resolved bits (their values go to
    /// `visible`) and bits that go on to the next level. With `last`, every hit is resolved. Returns bit 0 if
    /// there are misses and bit 1 if bits go on.
    int (*step)(Word* a, RowPair own, const RowPair neighbours[4], bool last, Word* miss, Word* visible,
                size_t words, RowCounts& counts);
    uint64_t (*count)(const Word* a, size_t words);
};

/// The variant for `isa`; the one in use is row_kernels(active_isa()).
const RowKernels& row_kernels(Isa isa);

}  // namespace viscache

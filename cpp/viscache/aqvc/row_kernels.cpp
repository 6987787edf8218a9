#include "viscache/aqvc/row_kernels.h"

#include "viscache/math/isa_variants.h"

namespace viscache {
namespace {

// Eight words; the compiler splits the vector where registers are smaller.
typedef Word Row512 __attribute__((vector_size(64), may_alias));
#define VISCACHE_INLINE inline __attribute__((always_inline))

VISCACHE_INLINE Row512 load_row(const Word* p) { return *reinterpret_cast<const Row512*>(p); }
VISCACHE_INLINE void store_row(Word* p, Row512 v) { *reinterpret_cast<Row512*>(p) = v; }
VISCACHE_INLINE bool any(const Row512& v) {
    return (v[0] | v[1] | v[2] | v[3] | v[4] | v[5] | v[6] | v[7]) != 0;
}
VISCACHE_INLINE uint64_t ones(const Row512& v) {
    uint64_t n = 0;
    for (int i = 0; i < 8; ++i) n += uint64_t(__builtin_popcountll(v[i]));
    return n;
}

// Bits that somebody needs, the representative wants and nobody knows. They count as known at once, so that
// no other eye point traces them; their values come with the rays.
VISCACHE_INLINE bool take_misses_body(const Word* need, const Word* active, Word* known, Word* miss,
                                      size_t words) {
    // need    1 1 0 1
    // active  1 0 1 1      miss = 0 0 0 1
    // known   1 0 0 0      known becomes 1 0 0 1
    Row512 left{};
    for (size_t w = 0; w < words; w += 8) {
        const Row512 k = load_row(known + w), m = load_row(need + w) & load_row(active + w) & ~k;
        store_row(miss + w, m);
        store_row(known + w, k | m);
        left |= m;
    }
    return any(left);
}

VISCACHE_INLINE void keep_body(Word* a, const Word* b, size_t words) {
    for (size_t w = 0; w < words; w += 8) store_row(a + w, load_row(a + w) & load_row(b + w));
}
VISCACHE_INLINE void drop_body(Word* a, const Word* known, const Word* resolved, size_t words) {
    for (size_t w = 0; w < words; w += 8)
        store_row(a + w, load_row(a + w) & ~(load_row(known + w) & load_row(resolved + w)));
}
VISCACHE_INLINE void store_below_body(const Word* mask, const Word* value, Word* known_below,
                                      Word* value_below, size_t words) {
    for (size_t w = 0; w < words; w += 8) {
        // What the finer level knows is newer and stays.
        const Row512 k = load_row(known_below + w), fresh = load_row(mask + w) & ~k;
        store_row(known_below + w, k | fresh);
        store_row(value_below + w, load_row(value_below + w) | (fresh & load_row(value + w)));
    }
}

VISCACHE_INLINE void adopt_body(Word* a, const Word* mask, const Word* value, Word* visible, size_t words,
                                RowCounts& counts) {
    for (size_t w = 0; w < words; w += 8) {
        const Row512 own = load_row(mask + w), open = load_row(a + w);
        // An own ray overrides what a coarser cell may have said.
        store_row(visible + w, (load_row(visible + w) & ~own) | (own & load_row(value + w)));
        store_row(a + w, open & ~own);
        const uint64_t answered = ones(open & own);
        counts.lookups += answered;
        counts.hits += answered;
    }
}

/// Bits in which a known neighbour has another value. Nil neighbours agree.
VISCACHE_INLINE Row512 differing(RowPair own, const RowPair neighbours[4], size_t w) {
    const Row512 v = load_row(own.value + w);
    Row512 d{};
    for (int q = 0; q < 4; ++q)
        d |= load_row(neighbours[q].known + w) & (load_row(neighbours[q].value + w) ^ v);
    return d;
}

// An unknown bit of the cell itself counts as disagreement: it is left to the finer level.
VISCACHE_INLINE void disagreement_body(RowPair own, const RowPair neighbours[4], Word* disagree,
                                       size_t words) {
    for (size_t w = 0; w < words; w += 8)
        store_row(disagree + w, differing(own, neighbours, w) | ~load_row(own.known + w));
}

VISCACHE_INLINE void resolve_body(Word* a, RowPair own, const Word* disagree, Word* visible, Word* need,
                                  size_t words, bool last_above, RowCounts& counts) {
    for (size_t w = 0; w < words; w += 8) {
        // `d` contains the unknown bits, so the rest of the queries is known and undisputed.
        const Row512 queries = load_row(a + w), d = load_row(disagree + w), rest = queries & d,
                     hit = queries & load_row(own.known + w);
        store_row(visible + w, load_row(visible + w) | (queries & ~d & load_row(own.value + w)));
        store_row(a + w, rest);
        store_row(need + w, load_row(need + w) | rest);
        counts.lookups += ones(queries);
        counts.hits += ones(hit);
        // What the finest level must answer
        if (last_above) counts.boundary += ones(hit & d);
    }
}

VISCACHE_INLINE bool finish_body(Word* a, RowPair own, Word* visible, size_t words, RowCounts& counts) {
    Row512 left{};
    for (size_t w = 0; w < words; w += 8) {
        const Row512 queries = load_row(a + w), hit = queries & load_row(own.known + w),
                     rest = queries & ~hit;
        store_row(visible + w, load_row(visible + w) | (hit & load_row(own.value + w)));
        store_row(a + w, rest);
        counts.lookups += ones(queries);
        counts.hits += ones(hit);
        left |= rest;
    }
    return any(left);
}

///     a  =  miss        unknown: waits for rays
///        | agreed       known, and all neighbours agree or are nil: the value is the answer
///        | rest         known, and some neighbour differs: is left to the next level
VISCACHE_INLINE int step_body(Word* a, RowPair own, const RowPair neighbours[4], bool last, Word* miss,
                              Word* visible, size_t words, RowCounts& counts) {
    Row512 missing{}, going{};
    for (size_t w = 0; w < words; w += 8) {
        const Row512 queries = load_row(a + w), hit = queries & load_row(own.known + w), m = queries & ~hit;
        // At the last level every hit is an answer.
        const Row512 rest = last ? Row512{} : hit & differing(own, neighbours, w);
        store_row(miss + w, m);
        store_row(a + w, rest);
        store_row(visible + w, load_row(visible + w) | (hit & ~rest & load_row(own.value + w)));
        counts.lookups += ones(queries);
        counts.hits += ones(hit);
        missing |= m;
        going |= rest;
    }
    // Bit 0: misses, bit 1: bits that go on
    return int(any(missing)) | int(any(going)) << 1;
}

VISCACHE_INLINE uint64_t count_body(const Word* a, size_t words) {
    uint64_t n = 0;
    for (size_t w = 0; w < words; w += 8) n += ones(load_row(a + w));
    return n;
}

#undef VISCACHE_INLINE

constexpr RowKernels kernels_of(Isa isa) {
    return {variant_of<take_misses_body>(isa), variant_of<keep_body>(isa),
            variant_of<drop_body>(isa),        variant_of<store_below_body>(isa),
            variant_of<adopt_body>(isa),       variant_of<disagreement_body>(isa),
            variant_of<resolve_body>(isa),     variant_of<finish_body>(isa),
            variant_of<step_body>(isa),        variant_of<count_body>(isa)};
}

}  // namespace

const RowKernels& row_kernels(Isa isa) { return table_of<kernels_of>(isa); }

}  // namespace viscache

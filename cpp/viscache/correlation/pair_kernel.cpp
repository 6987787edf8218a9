#include "viscache/correlation/pair_kernel.h"

#include "viscache/math/x86_intrinsics.h"

namespace viscache {
namespace {

/// Calls visit(k) with the first word k of every live unit.
template <class Visit>
inline __attribute__((always_inline)) void for_each_unit(const Word* live, size_t live_words, Visit visit) {
    for (size_t m = 0; m < live_words; ++m)
        for (Word rest = live[m]; rest; rest &= rest - 1)
            visit((m * kWordBits + size_t(std::countr_zero(rest))) * kUnitWords);
}

struct Portable {
    static void quad(const Word* rows, const Word* columns, const Word* live, size_t live_words,
                     int32_t* counts) {
        std::fill_n(counts, kQuadRows * kPanelRows, 0);
        for_each_unit(live, live_words, [&](size_t k) {
            for (size_t w = k; w < k + kUnitWords; ++w)
                for (size_t r = 0; r < kQuadRows; ++r)
                    for (size_t c = 0; c < kPanelRows; ++c)
                        // One bit-and per word of 64 directions
                        counts[r * kPanelRows + c] +=
                            std::popcount(rows[w * kPanelRows + r] & columns[w * kPanelRows + c]);
        });
    }
    static uint32_t dot(const Word* a, const Word* b, size_t words) {
        uint32_t n = 0;
        for (size_t w = 0; w < words; ++w) n += uint32_t(std::popcount(a[w] & b[w]));
        return n;
    }
};

#if VISCACHE_X86

struct Avx2 {
    /// Number of set bits in every byte, from a table over nibbles.
    VISCACHE_TARGET_AVX2 static inline __m256i bytes(__m256i v) {
        // Counts of the nibbles 0 ... 15, once per 128-bit lane
        const __m256i table = _mm256_setr_epi8(0, 1, 1, 2, 1, 2, 2, 3, 1, 2, 2, 3, 2, 3, 3, 4, 0, 1, 1, 2, 1,
                                               2, 2, 3, 1, 2, 2, 3, 2, 3, 3, 4);
        const __m256i nibble = _mm256_set1_epi8(15);
        const __m256i low = _mm256_shuffle_epi8(table, _mm256_and_si256(v, nibble));
        const __m256i high = _mm256_shuffle_epi8(table, _mm256_and_si256(_mm256_srli_epi16(v, 4), nibble));
        return _mm256_add_epi8(low, high);
    }
    /// Two rows and four columns; `units` lists the first word of each live unit.
    VISCACHE_TARGET_AVX2 static void two_by_four(const Word* rows, const Word* columns, const uint32_t* units,
                                                 size_t n, int32_t* counts) {
        // A byte holds the counts of up to 15 units of two words: 15 · 2 · 8 = 240
        constexpr size_t kUnitsPerByte = 15;
        const __m256i zero = _mm256_setzero_si256();
        __m256i sum[2] = {zero, zero};
        for (size_t first = 0; first < n; first += kUnitsPerByte) {
            __m256i part[2] = {zero, zero};
            for (size_t u = first; u < std::min(n, first + kUnitsPerByte); ++u)
                for (size_t w = units[u]; w < units[u] + kUnitWords; ++w) {
                    const __m256i b =
                        _mm256_load_si256(reinterpret_cast<const __m256i*>(columns + w * kPanelRows));
                    for (size_t r = 0; r < 2; ++r) {
                        const __m256i a = _mm256_set1_epi64x(int64_t(rows[w * kPanelRows + r]));
                        part[r] = _mm256_add_epi8(part[r], bytes(_mm256_and_si256(a, b)));
                    }
                }
            // Sums of bytes: four 64-bit sums per vector, one per column.
            for (size_t r = 0; r < 2; ++r) sum[r] = _mm256_add_epi64(sum[r], _mm256_sad_epu8(part[r], zero));
        }
        for (size_t r = 0; r < 2; ++r) {
            alignas(32) int64_t lanes[4];
            _mm256_store_si256(reinterpret_cast<__m256i*>(lanes), sum[r]);
            for (size_t c = 0; c < 4; ++c) counts[r * kPanelRows + c] = int32_t(lanes[c]);
        }
    }
    VISCACHE_TARGET_AVX2 static void quad(const Word* rows, const Word* columns, const Word* live,
                                          size_t live_words, int32_t* counts) {
        uint32_t units[kMaxLiveWords * kWordBits];
        size_t n = 0;
        // The units are the same for all eight blocks of rows and columns: their numbers are listed once.
        for_each_unit(live, live_words, [&](size_t k) { units[n++] = uint32_t(k); });
        for (size_t r = 0; r < kQuadRows; r += 2)
            for (size_t c = 0; c < kPanelRows; c += 4)
                two_by_four(rows + r, columns + c, units, n, counts + r * kPanelRows + c);
    }
    VISCACHE_TARGET_AVX2 static uint32_t dot(const Word* a, const Word* b, size_t words) {
        uint32_t n = 0;
        for (size_t w = 0; w < words; ++w) n += uint32_t(__builtin_popcountll(a[w] & b[w]));
        return n;
    }
};

struct Avx512 {
    /// Adds two words at a time with a carry-save adder. Let o be the running bits of weight 1. Then s = o ^
    /// a₀b₀ and t = s ^ a₁b₁ are the next ones, and the carry maj(o, a₀b₀, a₁b₁) is a function of (o, s, t)
    /// alone. Three ternary operations, a popcount and an add replace two times and + popcount + add.
    VISCACHE_TARGET_AVX512 static void quad(const Word* rows, const Word* columns, const Word* live,
                                            size_t live_words, int32_t* counts) {
        // Truth tables over (o, x, y), with the value at bit 4o + 2x + y: o ^ (x & y), and the carry as a
        // function of (o, s, t):
        //
        //     o s t    a0 b0 = o ^ s    a1 b1 = s ^ t    carry
        //     0 1 0         1                1             1
        //     1 0 *         1                *             1
        //     1 1 0         0                1             1        all others 0
        constexpr int kXorAnd = 0x78, kCarry = 0x74;
        __m512i ones[kQuadRows][2], twos[kQuadRows][2];
        for (size_t r = 0; r < kQuadRows; ++r)
            for (size_t h = 0; h < 2; ++h) ones[r][h] = twos[r][h] = _mm512_setzero_si512();
        for (size_t m = 0; m < live_words; ++m)
            for (Word rest = live[m]; rest; rest &= rest - 1) {
                const size_t k = (m * kWordBits + size_t(std::countr_zero(rest))) * kUnitWords * kPanelRows;
                const Word *a = rows + k, *b = columns + k;
                const __m512i b0[2] = {_mm512_load_si512(b), _mm512_load_si512(b + 8)};
                const __m512i b1[2] = {_mm512_load_si512(b + 16), _mm512_load_si512(b + 24)};
#pragma GCC unroll 4
                for (size_t r = 0; r < kQuadRows; ++r) {
                    const __m512i a0 = _mm512_set1_epi64(int64_t(a[r]));
                    const __m512i a1 = _mm512_set1_epi64(int64_t(a[r + kPanelRows]));
#pragma GCC unroll 2
                    for (size_t h = 0; h < 2; ++h) {
                        const __m512i o = ones[r][h];
                        const __m512i s = _mm512_ternarylogic_epi64(o, a0, b0[h], kXorAnd);
                        const __m512i t = _mm512_ternarylogic_epi64(s, a1, b1[h], kXorAnd);
                        const __m512i carry = _mm512_ternarylogic_epi64(o, s, t, kCarry);
                        twos[r][h] = _mm512_add_epi64(twos[r][h], _mm512_popcnt_epi64(carry));
                        ones[r][h] = t;
                    }
                }
            }
        for (size_t r = 0; r < kQuadRows; ++r)
            for (size_t h = 0; h < 2; ++h) {
                // Twice the carries, and what is left of weight 1
                const __m512i n =
                    _mm512_add_epi64(_mm512_slli_epi64(twos[r][h], 1), _mm512_popcnt_epi64(ones[r][h]));
                _mm256_storeu_si256(reinterpret_cast<__m256i*>(counts + r * kPanelRows + h * 8),
                                    _mm512_cvtepi64_epi32(n));
            }
    }
    VISCACHE_TARGET_AVX512 static uint32_t dot(const Word* a, const Word* b, size_t words) {
        __m512i sum = _mm512_setzero_si512();
        for (size_t w = 0; w < words; w += 8) {
            // The last load is partial: lanes outside read zeros.
            const __mmask8 in = words - w >= 8 ? 0xff : __mmask8((1u << (words - w)) - 1);
            const __m512i both =
                _mm512_and_si512(_mm512_maskz_loadu_epi64(in, a + w), _mm512_maskz_loadu_epi64(in, b + w));
            sum = _mm512_add_epi64(sum, _mm512_popcnt_epi64(both));
        }
        return uint32_t(_mm512_reduce_add_epi64(sum));
    }
};

VISCACHE_TARGET_AVX512 uint64_t and_popcount_add_avx512(size_t steps) {
    // Sixteen independent sums hide the latency of each.
    constexpr size_t kSums = 16;
    __m512i sum[kSums], a = _mm512_set1_epi64(0x5555), b = _mm512_set1_epi64(0x3333);
    for (__m512i& s : sum) s = _mm512_setzero_si512();
    for (size_t i = 0; i < steps; i += kSums)
#pragma GCC unroll 16
        for (size_t j = 0; j < kSums; ++j) {
#ifndef __clang__  // clang 14 knows no such operands
            // Keep the compiler from assuming that the operands stay the same
            __asm__("" : "+v"(a), "+v"(b));
#endif
            sum[j] = _mm512_add_epi64(sum[j], _mm512_popcnt_epi64(_mm512_and_si512(a, b)));
        }
    for (size_t j = 1; j < kSums; ++j) sum[0] = _mm512_add_epi64(sum[0], sum[j]);
    return uint64_t(_mm512_reduce_add_epi64(sum[0]));
}

#endif

template <class Variant>
constexpr PairKernel kKernel{Variant::quad, Variant::dot};

}  // namespace

const PairKernel& pair_kernel([[maybe_unused]] Isa isa) {
#if VISCACHE_X86
    if (isa == Isa::kAvx512) return kKernel<Avx512>;
    if (isa == Isa::kAvx2) return kKernel<Avx2>;
#endif
    return kKernel<Portable>;
}

void count_panels(const PairKernel& kernel, const BitPanels& a, size_t pa, const BitPanels& b, size_t pb,
                  int32_t* counts) {
    const size_t live_words = a.live_words();
    const Word* columns_live = b.live_panel(pb);
    // Units without a bit on one side give nothing: rows and columns must both be live.
    for (size_t first = 0; first < kPanelRows; first += kQuadRows) {
        const Word* rows_live = a.live_quad((pa * kPanelRows + first) / kQuadRows);
        Word live[kMaxLiveWords];
        for (size_t m = 0; m < live_words; ++m) live[m] = rows_live[m] & columns_live[m];
        kernel.quad(a.panel(pa) + first, b.panel(pb), live, live_words, counts + first * kPanelRows);
    }
}

uint64_t and_popcount_add([[maybe_unused]] size_t steps) {
#if VISCACHE_X86
    if (best_isa() == Isa::kAvx512) return and_popcount_add_avx512(steps);
#endif
    return 0;
}

}  // namespace viscache

#include "viscache/correlation/pair_bins.h"

#include "viscache/math/isa_variants.h"
#include "viscache/math/x86_intrinsics.h"

namespace viscache {

namespace {
typedef float F __attribute__((vector_size(64), aligned(4), may_alias));
typedef int32_t I __attribute__((vector_size(64), aligned(4), may_alias));
typedef uint32_t U __attribute__((vector_size(64), aligned(4), may_alias));
typedef uint64_t Pair __attribute__((vector_size(16), may_alias));

namespace portable {
// Position in `packed` → lane of the pair. Interleaving leaves lanes in the order of the instructions used.
constexpr int kPackedLane[16] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};
inline U gather(const uint32_t* table, I index) {
    U v;
    for (size_t l = 0; l < 16; ++l) v[l] = table[index[l]];
    return v;
}
inline void pack(I p, Pair* packed) {
    for (size_t l = 0; l < 16; ++l) {
        // Both sums of a pair are one vector of 128 bits: one load, one add, one store per pair.
        const auto v = uint64_t(p[l]);
        packed[l] = Pair{PackedSums::kOne + v, v * v};
    }
}
#include "pair_bins.inc"
}  // namespace portable

#if VISCACHE_X86
#pragma GCC push_options
#pragma GCC target("avx2,bmi,bmi2,popcnt")
namespace avx2 {
// Four lanes at a time: unpacklo takes 0 and 2, unpackhi takes 1 and 3.
constexpr int kPackedLane[16] = {0, 2, 1, 3, 4, 6, 5, 7, 8, 10, 9, 11, 12, 14, 13, 15};
inline U gather(const uint32_t* table, I index) {
    const auto* i = reinterpret_cast<const __m256i*>(&index);
    const auto* t = reinterpret_cast<const int*>(table);
    alignas(64) U v;
    for (int h = 0; h < 2; ++h)
        _mm256_store_si256(reinterpret_cast<__m256i*>(&v) + h,
                           _mm256_i32gather_epi32(t, _mm256_loadu_si256(i + h), 4));
    return v;
}
inline void pack(I p, Pair* packed) {
    // The count and ρ share a word: adding 2⁴³ + p counts the pair and adds its ρ.
    const __m256i one = _mm256_set1_epi64x(int64_t{PackedSums::kOne});
    for (int h = 0; h < 4; ++h) {
        const __m256i v = _mm256_cvtepu32_epi64(_mm_loadu_si128(reinterpret_cast<const __m128i*>(&p) + h));
        const __m256i sum = _mm256_add_epi64(v, one), squares = _mm256_mul_epu32(v, v);
        auto* out = reinterpret_cast<__m256i*>(packed + 4 * h);
        _mm256_store_si256(out, _mm256_unpacklo_epi64(sum, squares));
        _mm256_store_si256(out + 1, _mm256_unpackhi_epi64(sum, squares));
    }
}
#include "pair_bins.inc"
}  // namespace avx2
#pragma GCC pop_options

#pragma GCC push_options
#pragma GCC target("avx512f,avx512bw,avx512dq,avx512vl,avx2,bmi,bmi2,popcnt,prefer-vector-width=512")
namespace avx512 {
// As with AVX2, with eight lanes.
constexpr int kPackedLane[16] = {0, 2, 4, 6, 1, 3, 5, 7, 8, 10, 12, 14, 9, 11, 13, 15};
inline U gather(const uint32_t* table, I index) {
    return (U)_mm512_i32gather_epi32((__m512i)index, table, 4);
}
inline void pack(I p, Pair* packed) {
    const __m512i one = _mm512_set1_epi64(int64_t{PackedSums::kOne}), all = (__m512i)p;
    for (int h = 0; h < 2; ++h) {
        const __m512i v =
            _mm512_cvtepu32_epi64(h ? _mm512_extracti64x4_epi64(all, 1) : _mm512_castsi512_si256(all));
        const __m512i sum = _mm512_add_epi64(v, one), squares = _mm512_mul_epu32(v, v);
        _mm512_store_si512(packed + 8 * h, _mm512_unpacklo_epi64(sum, squares));
        _mm512_store_si512(packed + 8 * h + 4, _mm512_unpackhi_epi64(sum, squares));
    }
}
#include "pair_bins.inc"
}  // namespace avx512
#pragma GCC pop_options
#endif

}  // namespace

BinPanels bin_panels(Isa isa) { return VISCACHE_REGION(isa, bin); }

void resolve_row(const PairPoints& points, const PairBinning& binning, size_t row, size_t first_column,
                 int32_t* cells, int32_t* biased) {
    const RowKind a = points.kind[row];
    for (size_t l = 0; l < kPanelRows; ++l) {
        const RowKind b = points.kind[first_column + l];
        // A panel with itself: only pairs above the diagonal.
        const bool same_panel = row / kPanelRows == first_column / kPanelRows;
        if (a == RowKind::kPadding || b == RowKind::kPadding || (same_panel && first_column + l <= row))
            cells[l] = binning.no_pair();
        else
            resolve_pair(binning, a, b, cells[l], biased[l]);
    }
}

void resolve_pair(const PairBinning& binning, RowKind a, RowKind b, int32_t& cell, int32_t& biased) {
    if (a == RowKind::kDefined && b == RowKind::kDefined) return;
    // Both see nothing, or both everything: alike by the rule that was chosen.
    if (binning.one_if_both && a == b)
        biased = int32_t(2 * kRhoOne);
    else
        cell += binning.cells();
}

void TileBins::flush(PairTable& table, size_t group_pair) {
    constexpr uint64_t kSumMask = (uint64_t{1} << PackedSums::kCountShift) - 1;
    const int32_t stride = binning_.stride(), cells = binning_.cells();
    // The border of cells, for pairs outside the edges, is left out: codes count from 1.
    for (int32_t d = 0; d < binning_.n_distances; ++d)
        for (int32_t t = 0; t < binning_.n_angles; ++t) {
            const PackedSums& s = sums_[size_t((t + 1) * stride + d + 1)];
            const PackedSums& undefined = sums_[size_t(cells + (t + 1) * stride + d + 1)];
            const size_t cell = table.cell(group_pair, size_t(d), size_t(t));
            table.n_undefined[cell] += int64_t(undefined.count_and_sum >> PackedSums::kCountShift);
            const uint64_t n = s.count_and_sum >> PackedSums::kCountShift, sum = s.count_and_sum & kSumMask;
            if (!n) continue;
            // p = q + 2²⁰, so Σq² = Σp² − 2²¹·Σp + n·2⁴⁰. Unsigned overflow in between cancels
            const uint64_t squares = s.squares - (sum << (kRhoBits + 1)) + (n << (2 * kRhoBits));
            table.add(cell, int64_t(n), int64_t(sum) - int64_t(n << kRhoBits), squares);
        }
    std::fill(sums_.begin(), sums_.end(), PackedSums{});
    pending_ = 0;
}

}  // namespace viscache

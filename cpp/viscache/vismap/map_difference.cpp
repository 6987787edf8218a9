#include "viscache/vismap/map_difference.h"

#include "viscache/math/x86_intrinsics.h"

namespace viscache {
namespace {

uint32_t differing_portable(const Word* a, const Word* b, size_t words) {
    uint32_t n = 0;
    for (size_t w = 0; w < words; ++w) n += uint32_t(std::popcount(a[w] ^ b[w]));
    return n;
}

#if VISCACHE_X86
VISCACHE_TARGET_AVX2 uint32_t differing_avx2(const Word* a, const Word* b, size_t words) {
    uint32_t n = 0;
    for (size_t w = 0; w < words; ++w) n += uint32_t(__builtin_popcountll(a[w] ^ b[w]));
    return n;
}

VISCACHE_TARGET_AVX512 uint32_t differing_avx512(const Word* a, const Word* b, size_t words) {
    __m512i sum = _mm512_setzero_si512();
    for (size_t w = 0; w < words; w += 8) {
        // Maps of m = 4 have only four words; lanes outside read zeros and differ nowhere.
        const __mmask8 in = words - w >= 8 ? 0xff : __mmask8((1u << (words - w)) - 1);
        const __m512i differ =
            _mm512_xor_si512(_mm512_maskz_loadu_epi64(in, a + w), _mm512_maskz_loadu_epi64(in, b + w));
        sum = _mm512_add_epi64(sum, _mm512_popcnt_epi64(differ));
    }
    return uint32_t(_mm512_reduce_add_epi64(sum));
}
#endif

}  // namespace

CountDifferences count_differences([[maybe_unused]] Isa isa) {
#if VISCACHE_X86
    if (isa == Isa::kAvx512) return differing_avx512;
    if (isa == Isa::kAvx2) return differing_avx2;
#endif
    return differing_portable;
}

}  // namespace viscache

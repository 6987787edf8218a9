#include "viscache/shafts/shaft_kernels.h"

#include <cmath>

#include "viscache/math/isa_variants.h"
#include "viscache/math/x86_intrinsics.h"

namespace viscache {

void ShaftCounts::merge(const ShaftCounts& b) {
    nodes += b.nodes;
    blocks += b.blocks;
    lists += b.lists;
    pairs += b.pairs;
    doubted += b.doubted;
    long_lists += b.long_lists;
    asked += b.asked;
    packets += b.packets;
}

/// Doubles, so that lists of a descent grow in few steps; what they hold is kept.
ShaftItem* hold(std::vector<ShaftItem>& items, size_t count) {
    if (items.size() < count) items.resize(2 * count);
    return items.data();
}

namespace {

// Three sets of the same primitives. Numbers may differ between them, since bounds of error cover
// one or two roundings and approximate reciprocals. What the bounds leave open is traced, so
// answers do not differ
namespace portable {
#include "viscache/math/parts_portable.inc"
// By the sign bit, as the instructions of the other sets read it: −0 counts as negative
inline uint32_t negative(Part a) { return lanes_of(reinterpret_cast<decltype(a > a)>(a) < 0); }
// Two roundings here, one with FMA; the bound allows either
inline Part fused(Part a, Part b, Part c) { return a * b + c; }
// Exact is within the error that the callers allow
inline Part about_inverse(Part a) { return 1 / a; }
inline Part about_inverse_root(Part a) {
    Part r;
    for (size_t i = 0; i < kPartLanes; ++i) r[i] = 1 / std::sqrt(a[i]);
    return r;
}
// Chosen lanes move together, in their order, so that lists have no gaps
template <class Vector>
inline void keep(float* to, const Vector& from, uint32_t lanes) {
    for (uint32_t m = lanes; m; m &= m - 1) {
        const uint32_t i = uint32_t(__builtin_ctz(m));
        *to++ = from.p[i / kPartLanes][i % kPartLanes];
    }
}
#include "shaft_kernels.inc"
}  // namespace portable

#if VISCACHE_X86
#pragma GCC push_options
#pragma GCC target("avx2,fma,bmi,bmi2,popcnt")
namespace avx2 {
#include "viscache/math/parts_avx2.inc"
inline uint32_t negative(Part a) { return uint32_t(_mm256_movemask_ps(a)); }
inline Part fused(Part a, Part b, Part c) { return _mm256_fmadd_ps(a, b, c); }
inline Part about_inverse(Part a) { return _mm256_rcp_ps(a); }
inline Part about_inverse_root(Part a) { return _mm256_rsqrt_ps(a); }
template <class Vector>
inline void keep(float* to, const Vector& from, uint32_t lanes) {
    for (size_t i = 0; i < kShaftLanes / kPartLanes; ++i) {
        const uint32_t m = lanes >> (i * kPartLanes) & 0xff;
        // A permutation from a mask without a table: bytes 0 … 7 of the chosen lanes are packed and
        // widened to indices
        const uint64_t bytes = _pdep_u64(m, 0x0101010101010101u) * 0xff;  // bytes of the lanes that stay
        const __m128i order = _mm_cvtsi64_si128(int64_t(_pext_u64(0x0706050403020100u, bytes)));
        // Stores a whole register; what is beyond the chosen lanes is overwritten by the next part
        _mm256_storeu_ps(to, _mm256_permutevar8x32_ps(from.p[i], _mm256_cvtepu8_epi32(order)));
        to += __builtin_popcount(m);
    }
}
#include "shaft_kernels.inc"
}  // namespace avx2
#pragma GCC pop_options

#pragma GCC push_options
#pragma GCC target("avx512f,avx512bw,avx512dq,avx512vl,avx2,fma,bmi,bmi2,popcnt,prefer-vector-width=512")
namespace avx512 {
#include "viscache/math/parts_avx512.inc"
inline uint32_t negative(Part a) { return _mm512_movepi32_mask(_mm512_castps_si512(a)); }
inline Part fused(Part a, Part b, Part c) { return _mm512_fmadd_ps(a, b, c); }
inline Part about_inverse(Part a) { return _mm512_rcp14_ps(a); }
inline Part about_inverse_root(Part a) { return _mm512_rsqrt14_ps(a); }
template <class Vector>
inline void keep(float* to, const Vector& from, uint32_t lanes) {
    _mm512_storeu_ps(to, _mm512_maskz_compress_ps(__mmask16(lanes), from.p[0]));
}
#include "shaft_kernels.inc"
}  // namespace avx512
#pragma GCC pop_options
#endif

}  // namespace

AnswerLight shaft_kernel(Isa isa) { return VISCACHE_REGION(isa, answer_light); }

}  // namespace viscache

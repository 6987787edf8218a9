#include "viscache/shafts/shaft_kernels.h"

#include <cmath>

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
typedef float Part __attribute__((vector_size(16), may_alias));
constexpr size_t kPartLanes = 4;
inline Part all(float v) { return Part{v, v, v, v}; }
// A comparison gives lanes of all ones; one bit of each is kept
inline uint32_t lanes_of(decltype(Part{} > Part{}) m) {
    return uint32_t((m[0] & 1) | (m[1] & 2) | (m[2] & 4) | (m[3] & 8));
}
inline uint32_t at_least(Part a, Part b) { return lanes_of(a >= b); }
// By the sign bit, as the instructions of the other sets read it: −0 counts as negative
inline uint32_t negative(Part a) { return lanes_of(reinterpret_cast<decltype(a > a)>(a) < 0); }
inline Part smaller(Part a, Part b) { return a < b ? a : b; }
inline Part larger(Part a, Part b) { return a > b ? a : b; }
// Two roundings here, one with FMA; the bound allows either
inline Part fused(Part a, Part b, Part c) { return a * b + c; }
// Exact is within the error that the callers allow
inline Part about_inverse(Part a) { return 1 / a; }
inline Part about_inverse_root(Part a) {
    Part r;
    for (size_t i = 0; i < kPartLanes; ++i) r[i] = 1 / std::sqrt(a[i]);
    return r;
}
inline Part select(uint32_t lanes, Part a, Part b) {
    using Lanes = decltype(Part{} > Part{});
    const Lanes chosen{-int(lanes & 1), -int(lanes >> 1 & 1), -int(lanes >> 2 & 1), -int(lanes >> 3 & 1)};
    return chosen ? a : b;
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
typedef float Part __attribute__((vector_size(32), may_alias));
constexpr size_t kPartLanes = 8;
inline Part all(float v) { return _mm256_set1_ps(v); }
inline uint32_t at_least(Part a, Part b) {
    return uint32_t(_mm256_movemask_ps(_mm256_cmp_ps(a, b, _CMP_GE_OQ)));
}
inline uint32_t negative(Part a) { return uint32_t(_mm256_movemask_ps(a)); }
inline Part smaller(Part a, Part b) { return _mm256_min_ps(a, b); }
inline Part larger(Part a, Part b) { return _mm256_max_ps(a, b); }
inline Part fused(Part a, Part b, Part c) { return _mm256_fmadd_ps(a, b, c); }
inline Part about_inverse(Part a) { return _mm256_rcp_ps(a); }
inline Part about_inverse_root(Part a) { return _mm256_rsqrt_ps(a); }
inline Part select(uint32_t lanes, Part a, Part b) {
    // AVX2 has no masks of bits: bit i is spread to all bits of lane i
    const __m256i bit = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
    const __m256i set = _mm256_and_si256(_mm256_set1_epi32(int(lanes)), bit);
    return _mm256_blendv_ps(b, a, _mm256_castsi256_ps(_mm256_cmpeq_epi32(set, bit)));
}
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
typedef float Part __attribute__((vector_size(64), may_alias));
constexpr size_t kPartLanes = 16;
inline Part all(float v) { return _mm512_set1_ps(v); }
inline uint32_t at_least(Part a, Part b) { return _mm512_cmp_ps_mask(a, b, _CMP_GE_OQ); }
inline uint32_t negative(Part a) { return _mm512_movepi32_mask(_mm512_castps_si512(a)); }
inline Part smaller(Part a, Part b) { return _mm512_min_ps(a, b); }
inline Part larger(Part a, Part b) { return _mm512_max_ps(a, b); }
inline Part fused(Part a, Part b, Part c) { return _mm512_fmadd_ps(a, b, c); }
inline Part about_inverse(Part a) { return _mm512_rcp14_ps(a); }
inline Part about_inverse_root(Part a) { return _mm512_rsqrt14_ps(a); }
inline Part select(uint32_t lanes, Part a, Part b) { return _mm512_mask_blend_ps(__mmask16(lanes), b, a); }
template <class Vector>
inline void keep(float* to, const Vector& from, uint32_t lanes) {
    _mm512_storeu_ps(to, _mm512_maskz_compress_ps(__mmask16(lanes), from.p[0]));
}
#include "shaft_kernels.inc"
}  // namespace avx512
#pragma GCC pop_options
#endif

}  // namespace

AnswerLight shaft_kernel([[maybe_unused]] Isa isa) {
#if VISCACHE_X86
    if (isa == Isa::kAvx512) return avx512::answer_light;
    if (isa == Isa::kAvx2) return avx2::answer_light;
#endif
    return portable::answer_light;
}

}  // namespace viscache

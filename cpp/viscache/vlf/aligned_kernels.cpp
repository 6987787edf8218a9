#include "viscache/vlf/aligned_kernels.h"

#include <cstring>
#include <numeric>

#include "viscache/math/isa_variants.h"
#include "viscache/math/x86_intrinsics.h"

#define VISCACHE_LAMBDA __attribute__((always_inline))

namespace viscache {

ExactHit blocks_exactly(const float a[3], const float b[3], const float c[3], bool up, float reach) {
    // A product of two floats has at most 48 bits and is exact in double. The difference of two exact numbers
    // is rounded, but its sign is right: the edge functions decide exactly, with 0 only for points on an
    // edge.
    const auto product = [](float x, float y) { return double(x) * double(y); };
    const double ea = product(b[0], c[1]) - product(b[1], c[0]);
    const double eb = product(c[0], a[1]) - product(c[1], a[0]);
    const double ec = product(a[0], b[1]) - product(a[1], b[0]);
    // Counter-clockwise around the point, or clockwise
    const bool left = ea >= 0 && eb >= 0 && ec >= 0, right = ea <= 0 && eb <= 0 && ec <= 0;
    if (left == right) return {};  // outside, or edge-on
    // Depth of the triangle at the point, times its signed double area `det`: no division, so no rounding of
    // one.
    const double t = (ea * double(a[2]) + eb * double(b[2])) + ec * double(c[2]);
    const double det = std::fabs((ea + eb) + ec);
    // Divided by a negative `det` (clockwise corners), the depth has the other sign
    const bool hit =
        (left == up ? t > 0 : t < 0) && (reach == kInfinity || std::fabs(t) <= double(reach) * det);
    return {hit, float(std::fabs(eb) / det), float(std::fabs(ec) / det)};
}

namespace {

namespace portable {
#include "viscache/math/parts_portable.inc"
inline uint32_t above(Part a, Part b) { return lanes_of(a > b); }
inline float smallest(Part a) { return std::min(std::min(a[0], a[1]), std::min(a[2], a[3])); }
inline float largest(Part a) { return std::max(std::max(a[0], a[1]), std::max(a[2], a[3])); }
// Packs the chosen lanes to the left; the order stays:
//
//     from  a b c d e f g h     lanes 01101001 (a is the lowest bit)     to  a d f g
template <class T>
inline void keep(T* to, const T* from, uint32_t lanes) {
    for (uint32_t m = lanes; m; m &= m - 1) *to++ = from[__builtin_ctz(m)];
}
/// The same for the bits of a mask.
inline uint32_t keep_bits(uint32_t bits, uint32_t lanes) {
    uint32_t r = 0, n = 0;
    for (uint32_t m = lanes; m; m &= m - 1) r |= (bits >> __builtin_ctz(m) & 1) << n++;
    return r;
}
#include "aligned_kernels.inc"
}  // namespace portable

#if VISCACHE_X86
#pragma GCC push_options
// No variant may fuse a product with a sum: CMakeLists.txt turns contraction off, for equal bits.
#pragma GCC target("avx2,bmi,bmi2,popcnt")
namespace avx2 {
#include "viscache/math/parts_avx2.inc"
inline uint32_t above(Part a, Part b) {
    return uint32_t(_mm256_movemask_ps(_mm256_cmp_ps(a, b, _CMP_GT_OQ)));
}
inline float smallest(Part a) {
    __m128 v = _mm_min_ps(_mm256_castps256_ps128(a), _mm256_extractf128_ps(a, 1));
    v = _mm_min_ps(v, _mm_movehl_ps(v, v));
    return _mm_cvtss_f32(_mm_min_ss(v, _mm_shuffle_ps(v, v, 1)));
}
inline float largest(Part a) {
    __m128 v = _mm_max_ps(_mm256_castps256_ps128(a), _mm256_extractf128_ps(a, 1));
    v = _mm_max_ps(v, _mm_movehl_ps(v, v));
    return _mm_cvtss_f32(_mm_max_ss(v, _mm_shuffle_ps(v, v, 1)));
}
template <class T>
inline void keep(T* to, const T* from, uint32_t lanes) {
    for (size_t i = 0; i < kLanes; i += kPartLanes) {
        const uint32_t m = lanes >> i & 0xff;
        // No instruction of AVX2 compacts lanes, but BMI2 compacts bits. `pdep` spreads the mask over eight
        // bytes (00 or ff); `pext` gathers from the numbers 7...0 the bytes of the lanes that stay:
        //
        //     m = 01101001     bytes = 00ffff00ff0000ff     order = 06 05 03 00
        //
        // The permutation by these numbers moves the chosen lanes to the front.
        const uint64_t bytes = _pdep_u64(m, 0x0101010101010101u) * 0xff;  // bytes of the lanes that stay
        const __m128i order = _mm_cvtsi64_si128(int64_t(_pext_u64(0x0706050403020100u, bytes)));
        const __m256i v = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(from + i));
        _mm256_storeu_si256(reinterpret_cast<__m256i*>(to),
                            _mm256_permutevar8x32_epi32(v, _mm256_cvtepu8_epi32(order)));
        to += __builtin_popcount(m);
    }
}
inline uint32_t keep_bits(uint32_t bits, uint32_t lanes) { return _pext_u32(bits, lanes); }
#include "aligned_kernels.inc"
}  // namespace avx2
#pragma GCC pop_options

#pragma GCC push_options
// Without prefer-vector-width, the compiler splits some vectors of sixteen into two of eight.
#pragma GCC target("avx512f,avx512bw,avx512dq,avx512vl,avx2,bmi,bmi2,popcnt,prefer-vector-width=512")
namespace avx512 {
#include "viscache/math/parts_avx512.inc"
inline uint32_t above(Part a, Part b) { return _mm512_cmp_ps_mask(a, b, _CMP_GT_OQ); }
inline float smallest(Part a) { return _mm512_reduce_min_ps(a); }
inline float largest(Part a) { return _mm512_reduce_max_ps(a); }
template <class T>
inline void keep(T* to, const T* from, uint32_t lanes) {
    // Compacted in a register and stored whole: the instruction that compacts into memory is slow on some
    // CPUs.
    _mm512_storeu_si512(to, _mm512_maskz_compress_epi32(__mmask16(lanes), _mm512_loadu_si512(from)));
}
inline uint32_t keep_bits(uint32_t bits, uint32_t lanes) { return _pext_u32(bits, lanes); }
#include "aligned_kernels.inc"
}  // namespace avx512
#pragma GCC pop_options
#endif

}  // namespace

TraceAxis trace_axis_kernel(Isa isa) { return VISCACHE_REGION(isa, trace_axis); }

}  // namespace viscache

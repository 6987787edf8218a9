#include "viscache/sampling/sphere_batch.h"

#include "viscache/sampling/low_discrepancy.h"
#include "viscache/sampling/warp.h"

namespace viscache {
namespace {

inline __attribute__((always_inline)) void fill(uint32_t sx, uint32_t sy, uint32_t first, size_t n, float* x,
                                                float* y, float* z) {
    for (size_t i = 0; i < n; ++i) {
        const Vec2 u = sobol02(first + uint32_t(i), sx, sy);
        const bool below = u.x >= 0.5f;
        const Vec3 w = square_to_uniform_hemisphere({below ? 2 * u.x - 1 : 2 * u.x, u.y});
        x[i] = w.x;
        y[i] = w.y;
        z[i] = below ? -w.z : w.z;
    }
}

#if VISCACHE_X86
VISCACHE_TARGET_AVX512 void fill_avx512(uint32_t sx, uint32_t sy, uint32_t first, size_t n, float* x,
                                        float* y, float* z) {
    fill(sx, sy, first, n, x, y, z);
}
VISCACHE_TARGET_AVX2 void fill_avx2(uint32_t sx, uint32_t sy, uint32_t first, size_t n, float* x, float* y,
                                    float* z) {
    fill(sx, sy, first, n, x, y, z);
}
#endif

}  // namespace

void sphere_batch(uint32_t sx, uint32_t sy, uint32_t first, size_t n, float* x, float* y, float* z,
                  [[maybe_unused]] Isa isa) {
#if VISCACHE_X86
    if (isa == Isa::kAvx512) return fill_avx512(sx, sy, first, n, x, y, z);
    if (isa == Isa::kAvx2) return fill_avx2(sx, sy, first, n, x, y, z);
#endif
    fill(sx, sy, first, n, x, y, z);
}

}  // namespace viscache

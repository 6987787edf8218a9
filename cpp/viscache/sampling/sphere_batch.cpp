#include "viscache/sampling/sphere_batch.h"

#include "viscache/math/isa_variants.h"
#include "viscache/sampling/low_discrepancy.h"
#include "viscache/sampling/warp.h"

namespace viscache {
namespace {

inline __attribute__((always_inline)) void fill_sphere(uint32_t sx, uint32_t sy, uint32_t first, size_t n,
                                                       float* x, float* y, float* z) {
    for (size_t i = 0; i < n; ++i) {
        const Vec2 u = sobol02(first + uint32_t(i), sx, sy);
        // The first coordinate decides the hemisphere and is stretched back to [0, 1): both halves stay
        // evenly filled.
        const bool below = u.x >= 0.5f;
        const Vec3 w = square_to_uniform_hemisphere({below ? 2 * u.x - 1 : 2 * u.x, u.y});
        x[i] = w.x;
        y[i] = w.y;
        z[i] = below ? -w.z : w.z;
    }
}

}  // namespace

void sphere_batch(uint32_t sx, uint32_t sy, uint32_t first, size_t n, float* x, float* y, float* z, Isa isa) {
    variant_of<fill_sphere>(isa)(sx, sy, first, n, x, y, z);
}

}  // namespace viscache

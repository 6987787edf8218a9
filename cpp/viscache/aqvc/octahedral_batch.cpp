#include "viscache/aqvc/octahedral_batch.h"

#include <cmath>
#include <cstddef>

#include "viscache/math/isa_variants.h"

namespace viscache {
namespace {

/// Branch-free: random directions would mispredict branches, and the compiler vectorizes the loop.
inline __attribute__((always_inline)) void fill(const float* x, const float* y, const float* z, double* u,
                                                double* v, size_t n) {
    for (size_t i = 0; i < n; ++i) {
        const double dx = double(x[i]), dy = double(y[i]), dz = double(z[i]);
        const double l = std::fabs(dx) + std::fabs(dy) + std::fabs(dz);
        const double a = dx / l + (l - l), b = dy / l;  // NaN if l is infinite
        // sgn(0) = +1, as in `octahedral_square`.
        const double sa = a < 0 ? -1.0 : 1.0, sb = b < 0 ? -1.0 : 1.0;
        const double fa = (1 - std::fabs(b)) * sa, fb = (1 - std::fabs(a)) * sb;
        u[i] = 0.5 * (dz < 0 ? fa : a) + 0.5;
        v[i] = 0.5 * (dz < 0 ? fb : b) + 0.5;
    }
}

}  // namespace

void octahedral_batch(std::span<const float> x, std::span<const float> y, std::span<const float> z,
                      std::span<double> u, std::span<double> v, Isa isa) {
    variant_of<fill>(isa)(x.data(), y.data(), z.data(), u.data(), v.data(), x.size());
}

}  // namespace viscache

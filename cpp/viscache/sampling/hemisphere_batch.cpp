#include "viscache/sampling/hemisphere_batch.h"

#include "viscache/math/isa_variants.h"
#include "viscache/sampling/low_discrepancy.h"
#include "viscache/sampling/warp.h"

namespace viscache {
namespace {

template <class Warp>
inline __attribute__((always_inline)) void fill_hemisphere(const HemisphereSequence& s, uint32_t first,
                                                           uint32_t n, HemisphereBatch& out, Warp warp) {
    constexpr uint32_t kLanes = HemisphereBatch::kLanes;
    for (uint32_t block = 0; block < n; block += kLanes) {
        float *const x = out.x + block, *const y = out.y + block, *const z = out.z + block;
        float* const cosine = out.cosine + block;
        for (uint32_t i = 0; i < kLanes; ++i) {  // a fixed number of turns, or it is not vectorised
            const Vec3 local = warp(sobol02(first + block + i, s.scramble_x, s.scramble_y));
            const Vec3 w = s.frame.to_world(local);
            x[i] = w.x;
            y[i] = w.y;
            z[i] = w.z;
            cosine[i] = local.z;
        }
    }
}

inline __attribute__((always_inline)) void fill_batch(const HemisphereSequence& s, uint32_t first, uint32_t n,
                                                      HemisphereBatch& out) {
    if (s.cosine)
        fill_hemisphere(s, first, n, out, [](Vec2 u) { return square_to_cosine_hemisphere(u); });
    else
        fill_hemisphere(s, first, n, out, [](Vec2 u) { return square_to_uniform_hemisphere(u); });
}

}  // namespace

void hemisphere_batch(const HemisphereSequence& sequence, uint32_t first, uint32_t n, HemisphereBatch& out,
                      Isa isa) {
    variant_of<fill_batch>(isa)(sequence, first, n, out);
}

}  // namespace viscache

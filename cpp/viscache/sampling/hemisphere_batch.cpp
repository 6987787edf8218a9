#include "viscache/sampling/hemisphere_batch.h"

#include "viscache/math/isa_variants.h"
#include "viscache/sampling/low_discrepancy.h"
#include "viscache/sampling/warp.h"

namespace viscache {
namespace {

template <class Warp>
inline __attribute__((always_inline)) void fill(const HemisphereSequence& s, uint32_t first,
                                                HemisphereBatch& out, Warp warp) {
    for (uint32_t i = 0; i < HemisphereBatch::kSize; ++i) {
        const Vec3 local = warp(sobol02(first + i, s.scramble_x, s.scramble_y));
        const Vec3 w = s.frame.to_world(local);
        out.x[i] = w.x;
        out.y[i] = w.y;
        out.z[i] = w.z;
        out.cosine[i] = local.z;
    }
}

inline __attribute__((always_inline)) void fill_batch(const HemisphereSequence& s, uint32_t first,
                                                      HemisphereBatch& out) {
    if (s.cosine)
        fill(s, first, out, [](Vec2 u) { return square_to_cosine_hemisphere(u); });
    else
        fill(s, first, out, [](Vec2 u) { return square_to_uniform_hemisphere(u); });
}

}  // namespace

void hemisphere_batch(const HemisphereSequence& sequence, uint32_t first, HemisphereBatch& out, Isa isa) {
    variant_of<fill_batch>(isa)(sequence, first, out);
}

}  // namespace viscache

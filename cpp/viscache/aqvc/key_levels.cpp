#include "viscache/aqvc/key_levels.h"

#include "viscache/math/isa_variants.h"

namespace viscache {
namespace {

// Four chains of scheme 2 side by side, one per level. A single chain is a long dependency: each step waits
// for the one before.
typedef uint64_t Chains __attribute__((vector_size(8 * kLevelsAtOnce)));

#define VISCACHE_INLINE inline __attribute__((always_inline))

VISCACHE_INLINE void hash_body(const LevelKeys& keys, LevelHashes& out) {
    Chains d = Chains{} + hash_seed(HashScheme::kScheme2).bits;
    // The steps of `hash_slots`, in vectors.
    const auto step = [&]() __attribute__((always_inline)) {
        d = d * 2862933555777941757ull + 7046029254386353087ull;
        d ^= d << 21;
        d ^= d >> 35;
        d ^= d << 4;
    };
    for (size_t n = 0; n < keys[0].size(); ++n) {
        step();
        Chains slots;
        // Slots are unsigned in the hash: no sign reaches the high half.
        for (size_t level = 0; level < kLevelsAtOnce; ++level) slots[level] = uint32_t(keys[level][n]);
        d ^= slots;
    }
    step();
    for (size_t level = 0; level < kLevelsAtOnce; ++level)
        out[level] = {uint32_t(d[level] >> 32), uint32_t(d[level] & 0x7fffffffu)};
}

#undef VISCACHE_INLINE

}  // namespace

LevelHashes hash_levels(const LevelKeys& keys) {
    LevelHashes out;
    variant_of<hash_body>(active_isa())(keys, out);
    return out;
}

}  // namespace viscache

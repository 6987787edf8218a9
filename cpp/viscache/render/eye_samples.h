#pragma once
// Random numbers for the samples of one eye point.
#include "viscache/sampling/low_discrepancy.h"
#include "viscache/sampling/rng.h"

namespace viscache {

/// Randomised low-discrepancy samples of one eye point and purpose: a (0,2)-sequence for positions, and one
/// number per sample for choices. The choices are shuffled, because they would be correlated with the
/// positions otherwise.
struct EyeSamples {
    uint32_t sx, sy, choice_scramble, choice_shuffle;
    EyeSamples(uint64_t seed, Purpose purpose, uint64_t stream) {
        Rng rng(seed, purpose, stream, 0);
        sx = rng.next_u32();
        sy = rng.next_u32();
        choice_scramble = rng.next_u32();
        choice_shuffle = rng.next_u32();
    }
    Vec2 position(int i) const { return sobol02(uint32_t(i), sx, sy); }
    float choice(int i) const {
        return sobol02(owen_scramble(uint32_t(i), choice_shuffle), choice_scramble, 0).x;
    }
    /// The same with 32 more random bits.
    double fine_choice(int i) const {
        const uint64_t more = mix64((uint64_t(choice_scramble) << 32) + uint32_t(i)) >> 32;
        return double(choice(i)) + double(more) * 0x1p-56;
    }
};

}  // namespace viscache

#pragma once
// Random numbers for the samples of one eye point.
#include "viscache/render/eye_paths.h"
#include "viscache/sampling/low_discrepancy.h"
#include "viscache/sampling/rng.h"

namespace viscache {

/// A sample's number of its pixel in shuffled order; 0 stays 0. Nested: aligned blocks of 2^k numbers stay
/// together, so the points of a sequence at these numbers are as evenly spread as before.
inline uint32_t shuffled_sample(uint32_t sample, uint32_t shuffle) {
    return owen_scramble(sample, shuffle) ^ owen_scramble(0, shuffle);
}

/// Randomised low-discrepancy samples of one eye point and purpose: a (0,2)-sequence for positions, and one
/// number per sample for choices. The choices are shuffled, because they would be correlated with the
/// positions otherwise.
///
/// All eye points of a pixel go through one sequence: each takes a block of it, so their samples together are
/// as evenly spread as those of a single point. The blocks are shuffled, because they would be correlated
/// with the positions in the pixel otherwise. Powers of two samples leave the blocks nets.
///
/// Each frame has its own sequences, so passes are independent, and their differences tell the error.
struct EyeSamples {
    uint32_t sx, sy, choice_scramble, choice_shuffle;
    uint32_t first;  ///< index in the sequence of the eye point's first sample

    /// `samples`: number of samples of every eye point of the frame.
    EyeSamples(uint64_t seed, Purpose purpose, const EyeTile& eyes, uint32_t eye, int samples) {
        Rng rng(seed, purpose, eyes.pixel_stream(eye), 0);
        sx = rng.next_u32();
        sy = rng.next_u32();
        choice_scramble = rng.next_u32();
        choice_shuffle = rng.next_u32();
        first = shuffled_sample(eyes.sample(eye), rng.next_u32()) * uint32_t(samples);
    }
    Vec2 position(int i) const { return sobol02(first + uint32_t(i), sx, sy); }
    float choice(int i) const {
        return sobol02(owen_scramble(first + uint32_t(i), choice_shuffle), choice_scramble, 0).x;
    }
    /// The same with 32 more random bits.
    double fine_choice(int i) const {
        const uint64_t more = mix64((uint64_t(choice_scramble) << 32) + (first + uint32_t(i))) >> 32;
        return double(choice(i)) + double(more) * 0x1p-56;
    }
};

}  // namespace viscache

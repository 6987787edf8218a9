#pragma once
// Random numbers for the samples of one eye point.
#include "viscache/render/eye_paths.h"
#include "viscache/sampling/low_discrepancy.h"
#include "viscache/sampling/rng.h"

namespace viscache {

/// Randomised low-discrepancy samples of one eye point and purpose: a (0,2)-sequence for positions, and one
/// number per sample for choices. The choices are shuffled, because they would be correlated with the
/// positions otherwise.
///
/// All eye points of a pixel go through one sequence: each takes a block of it, so their samples together are
/// as evenly spread as those of a single point. The blocks are shuffled, because they would be correlated
/// with the positions in the pixel otherwise. Powers of two samples leave the blocks nets.
///
/// Frames that go on from each other go on in the sequences: n frames have the samples of one frame of n
/// times as many. So differences between passes overstate the error of their mean (progressive_state.py).
struct EyeSamples {
    uint32_t sx, sy, choice_scramble, choice_shuffle;
    uint32_t first;  ///< index in the sequence of the eye point's first sample

    /// `samples`: number of samples of every eye point of the frame.
    EyeSamples(uint64_t seed, Purpose purpose, const EyeTile& eyes, uint32_t eye, int samples) {
        // The key has no sample: all eye points of a place read one stream, and `first` says where
        Rng rng(seed, purpose, eyes.block.place[eye], eyes.sequence());
        sx = rng.next_u32();
        sy = rng.next_u32();
        // The numbers are drawn in this order for every purpose; a change of it changes every
        // picture
        choice_scramble = rng.next_u32();
        choice_shuffle = rng.next_u32();
        first = shuffled_sample(eyes.sample(eye), rng.next_u32()) * uint32_t(samples);
    }
    Vec2 position(int i) const { return sobol02(first + uint32_t(i), sx, sy); }
    float choice(int i) const {
        // Shuffled in the order of the sequence, which keeps every block of it a net
        return sobol02(owen_scramble(first + uint32_t(i), choice_shuffle), choice_scramble, 0).x;
    }
    /// The same with 32 more random bits.
    double fine_choice(int i) const {
        // For choices among many lights, where 24 bits would never reach the faintest
        const uint64_t more = mix64((uint64_t(choice_scramble) << 32) + (first + uint32_t(i))) >> 32;
        return double(choice(i)) + double(more) * 0x1p-56;
    }
};

}  // namespace viscache

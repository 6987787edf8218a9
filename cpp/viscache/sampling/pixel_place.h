#pragma once
// Sample positions within a pixel. All rendering methods use the same positions.
#include "viscache/sampling/low_discrepancy.h"
#include "viscache/sampling/rng.h"

namespace viscache {

/// Samples of a pixel that share its sequences, where frames go on from each other: of positions in the
/// pixel, and of the light samples and picks of its eye points. Later ones have new sequences.
constexpr uint64_t kSamplesPerSequence = 512;

/// Sample positions within one pixel, in [0, 1)². Each pixel has its own Owen-scrambled (0, 2)-sequence, and
/// a new one for frames whose first sample lies beyond the next kSamplesPerSequence.
class PixelPlaces {
public:
    PixelPlaces(uint64_t seed, uint64_t pixel, uint64_t first_sample = 0) {
        Rng rng(seed, Purpose::kPixel, pixel, first_sample / kSamplesPerSequence);
        scramble_x_ = rng.next_u32();
        scramble_y_ = rng.next_u32();
    }
    Vec2 operator[](uint32_t sample) const { return sobol02(sample, scramble_x_, scramble_y_); }

private:
    uint32_t scramble_x_, scramble_y_;
};

/// Position of one sample.
inline Vec2 pixel_place(uint64_t seed, uint64_t pixel, uint32_t sample) {
    return PixelPlaces(seed, pixel)[sample];
}

}  // namespace viscache

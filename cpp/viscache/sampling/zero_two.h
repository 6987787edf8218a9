#pragma once
// Points of the unit square for warps through deep trees. They have the full precision of a double, so that
// even a cell of probability 1e-12 is drawn with the right frequency.
#include "viscache/sampling/low_discrepancy.h"
#include "viscache/sampling/rng.h"

namespace viscache {

enum class PointSet {
    kIndependent,  ///< independent uniform points
    kZeroTwo,      ///< Owen-scrambled (0,2)-sequence; digits past the 32nd are random
};

struct Point2 {
    double x, y;  ///< in [0, 1)
};

/// The point stream of one pixel and pass, or the block of it that one of the pixel's samples takes. Blocks
/// are shuffled as in EyeSamples.
class PointStream {
public:
    PointStream(PointSet set, uint64_t seed, Purpose purpose, uint64_t pixel, uint64_t pass,
                uint32_t sample = 0, uint32_t points = 0)
        : set_(set) {
        Rng rng(seed, purpose, pixel, pass);
        scramble_x_ = rng.next_u32();
        scramble_y_ = rng.next_u32();
        key_ = uint64_t(rng.next_u32()) << 32 | rng.next_u32();
        // Blocks are shuffled as a whole: the points of a block stay together.
        first_ = shuffled_sample(sample, rng.next_u32()) * points;
    }
    /// Point i of the block.
    Point2 at(uint32_t i) const {
        i += first_;
        constexpr uint64_t kWeyl = 0x9E3779B97F4A7C15ull;
        // Two numbers per point: one for each coordinate, or the digits past the 32nd of both.
        const uint64_t a = mix64(key_ + (2 * uint64_t(i) + 1) * kWeyl);
        if (set_ == PointSet::kIndependent) {
            const uint64_t b = mix64(key_ + (2 * uint64_t(i) + 2) * kWeyl);
            return {to_unit_double(a), to_unit_double(b)};
        }
        const uint32_t x = owen_scramble_reversed(i, scramble_x_);
        const uint32_t y = owen_scramble_reversed(sobol2_reversed(i), scramble_y_);
        return {to_unit_double(uint64_t(x) << 32 | a >> 32), to_unit_double(uint64_t(y) << 32 | (a & ~0u))};
    }

private:
    static double to_unit_double(uint64_t x) { return double(x >> 11) * 0x1p-53; }

    PointSet set_;
    uint32_t scramble_x_, scramble_y_;
    uint64_t key_;
    uint32_t first_;
};

}  // namespace viscache

#pragma once
// Random choices of queries. Their keys come from eye points and pixels, never from tiles or threads.
#include <algorithm>
#include <cmath>

#include "viscache/sampling/point_key.h"
#include "viscache/visibility/oracle.h"

namespace viscache {

/// A share q of queries: each is drawn if 32 random bits are below a threshold.
struct RandomShare {
    uint64_t threshold;
    float inverse;  ///< 1/q of the rounded threshold

    explicit RandomShare(double q)
        : threshold(uint64_t(std::clamp(std::floor(q * 0x1p32), 1.0, 0x1p32))),
          inverse(float(0x1p32 / double(threshold))) {}
    bool draws(uint64_t key, uint64_t number) const {
        return (mix64(key + number * 0x9E3779B97F4A7C15ull) >> 32) < threshold;
    }
};

/// Keys of the eye points of the frames that have one seed.
struct EyeKeys {
    uint64_t seed;
    Purpose purpose;
    /// Seed of all frames that go on from each other.
    uint64_t lasting_seed = 0;

    uint64_t of(const EyeBlock& eyes, size_t eye, int group) const {
        Rng rng(seed, purpose, uint64_t(group), 0);
        return mix_point(rng.next_u32(), eyes.position[eye]);
    }
    /// A key that 2^halvings samples of a pixel share, which follow each other. Arrays of points, which have
    /// no pixels, have the key of the point.
    uint64_t of_turns(const EyeBlock& eyes, size_t eye, int group, size_t halvings) const {
        const uint64_t key =
            eyes.place.empty()
                ? of(eyes, eye, group)
                : Rng(lasting_seed, purpose, eyes.place[eye], eyes.turn[eye] >> halvings).next_u64();
        return key ^ mix64(uint64_t(group));
    }
};

}  // namespace viscache

#pragma once
// Picks some of the shared lights for each eye point, by their contribution without shadows.
//
// Systematic sampling: n points at equal distances, with one random offset, on the running sum of the
// contributions. A light that is longer than the distance is always hit, the others with a probability in
// proportion to their contribution. Weights are inverse probabilities, so the expectation is the sum over all
// lights (Madow 1949).
#include <cstdint>
#include <span>
#include <vector>

#include "viscache/render/eye_paths.h"
#include "viscache/render/shared_lights.h"

namespace viscache {

/// A light that an eye point picked.
struct PickedLight {
    uint32_t column;
    float weight;  ///< inverse of the probability
};

/// Appends at most `most` of the columns with a positive contribution, in their order. `u` in [0, 1).
/// False: every column counts, because at most `most` are positive or the sum is not finite.
bool pick_columns(std::span<const float> contributions, size_t most, double u, std::vector<PickedLight>& out);

/// The picks of the eye points of a tile, from one group of lights after another. The buffers are reused.
class TilePicks {
public:
    /// `most`: lights per eye point; 0: all lights.
    explicit TilePicks(size_t most, uint64_t seed) : most_(most), seed_(seed) {}

    /// Begins a group.
    void begin(const SharedLights& lights);
    /// Picks among the set bits of `wanted` for the next eye point, and clears the bits of the other lights.
    /// The offsets of a pixel's eye points go through one van der Corput sequence, so that together they pick
    /// like one eye point with as many picks. Frames that go on from each other go on in it.
    void add(const EyeShade& shade, const EyeTile& eyes, uint32_t eye, Word* wanted);
    /// What an eye point picked; empty: all lights, with weights of 1.
    std::span<const PickedLight> of(size_t eye) const {
        if (end_.empty()) return {};
        const size_t begin = eye ? end_[eye - 1] : 0;
        return {picked_.data() + begin, end_[eye] - begin};
    }

private:
    size_t most_;
    uint64_t seed_;
    const SharedLights* lights_ = nullptr;
    std::vector<PickedLight> picked_;
    std::vector<size_t> end_;  ///< of every eye point; empty: nothing is picked
    std::vector<float> contributions_;
};

}  // namespace viscache

#pragma once
// Counter-based random numbers: the same key gives the same stream on every machine and thread.
#include <cstdint>

#include "viscache/math/vec.h"

namespace viscache {

/// What the random numbers are used for. Streams of different purposes are independent.
enum class Purpose : uint32_t {
    kPixel,
    kAreaLight,
    kEnvironmentLight,
    kBrdf,
    kLens,
    kVplEmission,
    kVplBounce,
    kVplResampling,
    kAmbient,
    kBranch,
    kTest,
    kSurfacePoint,
    kDirectionPattern,
    kProduct,
    kMapStartup,
    kEyeSubpath,
    kLightSubpath,
    kRoulette,
    kResidual,
    kAreaBrdf,
    kLightPick,
    kAudit
};

/// Bijective 64-bit mixer (variant 13 of Stafford's murmur finalisers).
inline uint64_t mix64(uint64_t x) {
    x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9ull;
    x = (x ^ (x >> 27)) * 0x94D049BB133111EBull;
    return x ^ (x >> 31);
}

/// Stream keyed by (seed, purpose, pixel, pass): a Weyl sequence passed through `mix64`. The key determines
/// its start and its step.
class Rng {
public:
    Rng(uint64_t seed, Purpose purpose, uint64_t pixel, uint64_t pass) {
        // Each part of the key has a constant of its own, so that exchanged values give different streams.
        uint64_t k = mix64(seed + 0x9E3779B97F4A7C15ull);
        k = mix64(k ^ mix64(uint64_t(purpose) + 0xD1B54A32D192ED03ull));
        k = mix64(k ^ mix64(pixel + 0x8CB92BA72F3D8DD7ull));
        state_ = mix64(k ^ mix64(pass + 0xABC98388FB8FAC03ull));
        // Odd, so that the sequence visits all 2⁶⁴ states. With one step for all, streams would be parts of
        // one sequence.
        step_ = mix64(state_ ^ 0x2545F4914F6CDD1Dull) | 1;
    }
    uint64_t next_u64() { return mix64(state_ += step_); }
    uint32_t next_u32() { return uint32_t(mix64(state_ += step_) >> 32); }
    /// Uniform in [0, 1), with 24 bits.
    float next() { return float(next_u32() >> 8) * 0x1p-24f; }
    Vec2 next2() {
        const float x = next();
        return {x, next()};
    }

private:
    uint64_t state_, step_;
};

}  // namespace viscache

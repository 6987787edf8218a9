#pragma once
// Hashes keys to slots and digests.
#include <cstdint>
#include <span>

#include "viscache/aqvc/cluster_key.h"
#include "viscache/aqvc/parameters.h"

namespace viscache {

struct KeyHash {
    uint32_t kappa = 0;   ///< chooses the slot
    uint32_t digest = 0;  ///< 31 bits that identify the key within a slot
    bool operator==(const KeyHash&) const = default;
};

// The constants are ours, since the paper gives none. `lcg1` is that of Numerical Recipes; with an odd
// multiplier, all steps are invertible, so a step loses no information.
namespace detail {
constexpr uint32_t lcg1(uint32_t v) { return v * 1664525u + 1013904223u; }
constexpr uint32_t lcg2(uint32_t v) { return v * 2891336453u + 1640531513u; }
constexpr uint64_t lcg64(uint64_t v) { return v * 2862933555777941757ull + 7046029254386353087ull; }
constexpr uint64_t xorshift64(uint64_t v) {
    v ^= v << 21;
    v ^= v >> 35;
    return v ^ v << 4;
}
/// Finaliser of MurmurHash3, which is not linear in the bits.
constexpr uint32_t mix32(uint32_t h) {
    h ^= h >> 16;
    h *= 0x85ebca6bu;
    h ^= h >> 13;
    h *= 0xc2b2ae35u;
    return h ^ h >> 16;
}
}  // namespace detail

/// State of the recurrences after some slots of a key: d for scheme 2, κ (high half) and c for scheme 1.
struct HashState {
    uint64_t bits = 0;
    uint32_t salt = 0;  ///< salt of the next slot, for kScheme1Mixed
};

inline HashState hash_seed(HashScheme scheme) {
    // The seed of scheme 2 is Marsaglia's for his xorshift generators.
    return {scheme == HashScheme::kScheme2 ? 88172645463325252ull : uint64_t{12345} << 32 | 67890, 0};
}

/// [AQVC Eq. 10] One of the two recurrences of the paper over the slots of a key, with our seeds and
/// constants.
// Differs (A16): scheme 1 uses the high 31 bits of c. It stays linear: two flipped signs cancel in both
// recurrences, so lights at (x, y, z) and (−x, y, −z) always collide. kScheme1Mixed passes every slot through
// a mixer first.
inline HashState hash_slots(HashState state, std::span<const int32_t> slots, HashScheme scheme) {
    using namespace detail;
    if (scheme == HashScheme::kScheme2) {
        for (int32_t j : slots) state.bits = xorshift64(lcg64(state.bits)) ^ uint32_t(j);
        return state;
    }
    uint32_t kappa = uint32_t(state.bits >> 32), c = uint32_t(state.bits);
    for (int32_t slot : slots) {
        // The salt differs from slot to slot, so that exchanged values give another hash.
        const uint32_t j =
            scheme == HashScheme::kScheme1 ? uint32_t(slot) : mix32(uint32_t(slot) + state.salt);
        kappa = lcg1(kappa) ^ j;
        c = lcg2(c) + j;
        state.salt += 0x9e3779b9u;
    }
    state.bits = uint64_t{kappa} << 32 | c;
    return state;
}

/// The last step of the recurrences.
inline KeyHash hash_end(HashState state, HashScheme scheme) {
    using namespace detail;
    if (scheme == HashScheme::kScheme2) {
        const uint64_t d = xorshift64(lcg64(state.bits));
        return {uint32_t(d >> 32), uint32_t(d & 0x7fffffffu)};
    }
    // The high bits of a linear recurrence are the better ones.
    return {lcg1(uint32_t(state.bits >> 32)), lcg2(uint32_t(state.bits)) >> 1};
}

inline KeyHash hash_key(std::span<const int32_t, 15> key, HashScheme scheme) {
    return hash_end(hash_slots(hash_seed(scheme), key, scheme), scheme);
}

/// The part of a key that describes the eye point, hashed once for all far ends.
struct KeyHead {
    std::array<int32_t, 8> slots{};
    HashState state;
};

}  // namespace viscache

#pragma once
// Hashes four keys at once: those of one query at four levels (AQVC Sec. 4.4, which uses SSE).
#include <array>

#include "viscache/aqvc/hash.h"

namespace viscache {

constexpr size_t kLevelsAtOnce = 4;
using LevelKeys = std::array<FullKey, kLevelsAtOnce>;
using LevelHashes = std::array<KeyHash, kLevelsAtOnce>;

/// Hashes of four keys by scheme 2, in vectors of four. They equal those of `hash_key` on every CPU.
LevelHashes hash_levels(const LevelKeys& keys);

}  // namespace viscache

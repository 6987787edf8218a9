#pragma once
// Hashes of the keys of four levels of one query at once (AQVC Sec. 4.4, there with SSE).
#include <array>

#include "viscache/aqvc/hash.h"

namespace viscache {

constexpr size_t kLevelsAtOnce = 4;
using LevelKeys = std::array<FullKey, kLevelsAtOnce>;
using LevelHashes = std::array<KeyHash, kLevelsAtOnce>;

/// The keys of a query at four levels, by scheme 2: four chains side by side in vectors of four. The same
/// values as `hash_key` on every CPU.
LevelHashes hash_levels(const LevelKeys& keys);

}  // namespace viscache

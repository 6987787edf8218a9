#pragma once
// The cache itself (AQVC Sec. 4.1): an array of 32-bit words, 31 bits of digest and one of visibility.
// No probing: a write replaces what was there. And a map of full keys that never forgets, for tests and
// experiments.
#include <algorithm>
#include <cstdint>
#include <optional>
#include <unordered_map>
#include <vector>

#include "viscache/aqvc/hash.h"

namespace viscache {

/// Largest prime <= n; 1 for n < 2 (a table of one slot).
inline uint64_t largest_prime(uint64_t n) {
    const auto is_prime = [](uint64_t v) {
        for (uint64_t d = 2; d * d <= v; ++d)
            if (v % d == 0) return false;
        return true;
    };
    if (n < 2) return 1;
    while (!is_prime(n)) --n;
    return n;
}

struct TableCounts {
    uint64_t writes = 0, evictions = 0;
    double expected_false_hits = 0;
};

/// Lossy table. Word 0 = empty; digest 0 is stored as 1.
class BitTable {
public:
    BitTable(uint64_t slots, int digest_bits, HashScheme scheme)
        : words_(size_t(std::clamp<uint64_t>(slots, 1, 0xffffffffu)), 0),
          scheme_(scheme),
          digest_bits_(digest_bits),
          false_rate_(std::ldexp(1 + std::ldexp(2.0, -digest_bits), -digest_bits) / double(words_.size())) {}

    KeyHead head(const std::array<int32_t, 8>& slots) const {
        return {slots, hash_slots(hash_seed(scheme_), slots, scheme_)};
    }
    std::optional<bool> get(const KeyHead& head, const FarKey& far) const {
        return get_hashed(hash_end(hash_slots(head.state, far.slots, scheme_), scheme_));
    }
    std::optional<bool> get(const FullKey& key) const { return get_hashed(hash_key(key, scheme_)); }
    void put(const FullKey& key, bool visible, TableCounts& counts) {
        put_hashed(hash_key(key, scheme_), visible, counts);
    }

    std::optional<bool> get_hashed(KeyHash h) const {
        const uint32_t word = words_[slot(h)];
        return word && word >> 1 == digest(h) ? std::optional(bool(word & 1)) : std::nullopt;
    }
    void put_hashed(KeyHash h, bool visible, TableCounts& counts) {
        uint32_t& word = words_[slot(h)];
        counts.expected_false_hits += double(occupied_) * false_rate_;
        counts.writes += 1;
        if (!word)
            ++occupied_;
        else if (word >> 1 != digest(h))
            ++counts.evictions;
        word = digest(h) << 1 | uint32_t(visible);
    }
    void clear() {
        if (occupied_) std::fill(words_.begin(), words_.end(), 0u);
        occupied_ = 0;
    }
    uint64_t slots() const { return words_.size(); }
    uint64_t occupied() const { return occupied_; }

private:
    size_t slot(KeyHash h) const { return h.kappa % uint32_t(words_.size()); }
    /// The low bits of scheme 2, the high bits of the linear chains of scheme 1.
    uint32_t digest(KeyHash h) const {
        const uint32_t all = scheme_ == HashScheme::kScheme2 ? h.digest & ((1u << digest_bits_) - 1)
                                                             : h.digest >> (31 - digest_bits_);
        return all ? all : 1;
    }
    std::vector<uint32_t> words_;
    HashScheme scheme_;
    int digest_bits_;
    double
        false_rate_;  ///< chance that a new key finds its digest in one occupied slot, per slot of the table
    uint64_t occupied_ = 0;
};

/// Exact map of full keys.
class ExactTable {
public:
    KeyHead head(const std::array<int32_t, 8>& slots) const { return {slots, {}}; }
    std::optional<bool> get(const KeyHead& head, const FarKey& far) const {
        return get(CellGrid::full_key(head.slots, far));
    }
    std::optional<bool> get(const FullKey& key) const {
        const auto found = map_.find(key);
        return found == map_.end() ? std::nullopt : std::optional(found->second);
    }
    void put(const FullKey& key, bool visible, TableCounts& counts) {
        map_[key] = visible;
        counts.writes += 1;
    }
    void clear() { map_.clear(); }
    uint64_t slots() const { return 0; }

private:
    struct Hash {
        size_t operator()(const FullKey& key) const {
            const KeyHash h = hash_key(key, HashScheme::kScheme2);
            return size_t(uint64_t(h.kappa) << 32 | h.digest);
        }
    };
    std::unordered_map<FullKey, bool, Hash> map_;
};

}  // namespace viscache

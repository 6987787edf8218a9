#pragma once
// The cache (AQVC Sec. 4.1): an array of 32-bit words, each with a 31-bit digest and one visibility bit.
// There is no probing: a write replaces the previous entry. `ExactTable` is a map of full keys without loss,
// for tests and experiments.
#include <algorithm>
#include <atomic>
#include <cstdint>
#include <optional>
#include <type_traits>
#include <unordered_map>
#include <vector>

#include "viscache/aqvc/hash.h"

namespace viscache {

/// The largest prime <= n; 1 for n < 2, so a table has at least one slot.
/// A prime number of slots uses all bits of κ. A power of two would use only the low ones, in which the
/// linear recurrences of scheme 1 see only low bits of the key: round coordinates would share one slot.
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
    uint64_t duplicates = 0;  ///< writes of a key that is present: the ray was traced twice
    double expected_false_hits = 0;
};

// One code for both kinds of words: plain ones, and relaxed atomics.
namespace detail {
template <class T>
T load(const T& word) {
    return word;
}
template <class T>
T load(const std::atomic<T>& word) {
    return word.load(std::memory_order_relaxed);
}
template <class T>
void store(T& word, T value) {
    word = value;
}
template <class T>
void store(std::atomic<T>& word, T value) {
    word.store(value, std::memory_order_relaxed);
}
inline void increment(uint64_t& count) { ++count; }
inline void increment(std::atomic<uint64_t>& count) { count.fetch_add(1, std::memory_order_relaxed); }
}  // namespace detail

/// Lossy table. A word of 0 is an empty slot; digest 0 is stored as 1. With kRacing, many threads read and
/// write through relaxed atomics. A reader sees an old word or a new one, never a mix.
///
///     bit 31 ................. 1   0
///     |        digest          | V |
// Relaxed order is enough: a word means the same whatever other words contain.
template <bool kRacing>
class BasicBitTable {
    template <class T>
    using Cell = std::conditional_t<kRacing, std::atomic<T>, T>;

public:
    BasicBitTable(uint64_t slots, int digest_bits, HashScheme scheme)
        // κ has 32 bits, and `slot` divides by a number of 32 bits.
        : words_(size_t(std::clamp<uint64_t>(slots, 1, 0xffffffffu))),
          scheme_(scheme),
          seed_(hash_seed(scheme)),
          digest_bits_(digest_bits),
          // A new key finds a false answer if its slot is occupied (probability n / C_T for n entries) by the
          // same digest. For digests of b bits, of which 0 becomes 1, that is 2^−b (1 + 2^(1−b)).
          false_rate_(std::ldexp(1 + std::ldexp(2.0, -digest_bits), -digest_bits) / double(words_.size())) {}

    /// Changes the hash of all keys. Entries of earlier epochs are not found again and are overwritten over
    /// time. Not safe while other threads read or write.
    void set_epoch(uint64_t epoch) {
        seed_ = hash_seed(scheme_);
        if (epoch) seed_.bits ^= murmur64(epoch);
    }
    KeyHead head(const std::array<int32_t, 8>& slots) const {
        return {slots, hash_slots(seed_, slots, scheme_)};
    }
    KeyHash hash(const KeyHead& head, const FarKey& far) const {
        return hash_end(hash_slots(head.state, far.slots, scheme_), scheme_);
    }
    KeyHash hash(const FullKey& key) const { return hash_end(hash_slots(seed_, key, scheme_), scheme_); }
    std::optional<bool> get(const KeyHead& head, const FarKey& far) const {
        return get_hashed(hash(head, far));
    }
    std::optional<bool> get(const FullKey& key) const { return get_hashed(hash(key)); }
    void put(const FullKey& key, bool visible, TableCounts& counts) {
        put_hashed(hash(key), visible, counts);
    }

    std::optional<bool> get_hashed(KeyHash h) const {
        // A digest is never 0, so the word 0 is nil.
        const uint32_t word = detail::load(words_[slot(h)]);
        return word && word >> 1 == digest(h) ? std::optional(bool(word & 1)) : std::nullopt;
    }
    void put_hashed(KeyHash h, bool visible, TableCounts& counts) {
        auto& word = words_[slot(h)];
        const uint32_t before = detail::load(word), own = digest(h);
        // Each write follows a miss: of this many misses, that share was expected to be answered falsely
        // instead.
        counts.expected_false_hits += double(occupied()) * false_rate_;
        counts.writes += 1;
        if (!before)
            detail::increment(occupied_);
        else
            ++(before >> 1 == own ? counts.duplicates : counts.evictions);
        detail::store(word, own << 1 | uint32_t(visible));
    }
    void clear() {
        // An empty table is left as it is: clearing megabytes per tile would show.
        if (occupied())
            for (auto& word : words_) detail::store(word, 0u);
        detail::store(occupied_, uint64_t{0});
    }
    /// Number of the entry that a key uses.
    uint64_t entry(const FullKey& key) const { return slot(hash(key)); }
    uint64_t slots() const { return words_.size(); }
    uint64_t occupied() const { return detail::load(occupied_); }
    // A remainder of 32-bit numbers; C_T is prime.
    size_t slot(KeyHash h) const { return h.kappa % uint32_t(words_.size()); }
    /// Digest and bit of a slot; 0 if empty.
    uint32_t word(size_t slot) const { return detail::load(words_[slot]); }

private:
    /// Low bits for scheme 2, high bits for the linear recurrences of scheme 1.
    uint32_t digest(KeyHash h) const {
        const uint32_t all = scheme_ == HashScheme::kScheme2 ? h.digest & ((1u << digest_bits_) - 1)
                                                             : h.digest >> (31 - digest_bits_);
        return all ? all : 1;
    }
    std::vector<Cell<uint32_t>> words_;
    HashScheme scheme_;
    HashState seed_;
    int digest_bits_;
    /// Probability that a new key matches the digest of one occupied slot, divided by the number of slots.
    double false_rate_;
    Cell<uint64_t> occupied_{0};
};
using BitTable = BasicBitTable<false>;
using RacingBitTable = BasicBitTable<true>;

/// Lossless map of full keys.
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
        counts.duplicates += !map_.insert_or_assign(key, visible).second;
        counts.writes += 1;
    }
    /// Number of the entry of a key that is present; valid until `clear`.
    // The address of an element stays the same until `clear`, so it serves as a number.
    uint64_t entry(const FullKey& key) const { return reinterpret_cast<uintptr_t>(&*map_.find(key)); }
    void clear() { map_.clear(); }
    uint64_t slots() const { return 0; }
    uint64_t occupied() const { return map_.size(); }

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

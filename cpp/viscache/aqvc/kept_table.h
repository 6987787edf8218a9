#pragma once
// A table that is kept between frames.
//
// A frame reads the table in the state that earlier frames left. Each tile also has its own table on top of
// it. The writes of a tile are deferred and applied at the end of the frame, in the order of the tiles, so
// the values do not depend on the number of threads. A new epoch invalidates all entries at once.
#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

#include "viscache/aqvc/bit_table.h"
#include "viscache/visibility/counters.h"

namespace viscache {

/// A write in 64 bits: κ, the digest and the visibility bit.
using PackedWrite = uint64_t;
// |     κ (32)     |   digest (31)   | V |
inline PackedWrite pack_write(KeyHash h, bool visible) {
    return uint64_t{h.kappa} << 32 | uint64_t{h.digest} << 1 | uint64_t{visible};
}

/// Which reused bits are also traced.
struct KeptChecks {
    double share = 0;     ///< fraction of the reused bits
    bool repair = false;  ///< check only bits of earlier frames; the answer of the ray is used and stored
};

/// An occupied slot.
struct KeptEntry {
    uint32_t slot, digest;
    bool visible;
    bool current;  ///< entry of the current epoch, which can be found
};

class KeptTable {
public:
    KeptTable(uint64_t bytes, int digest_bits, HashScheme scheme)
        : bits_(largest_prime(bytes / 4), digest_bits, scheme) {}

    const BitTable& bits() const { return bits_; }
    uint64_t epoch() const { return epoch_; }
    uint64_t frames() const { return frames_; }  ///< finished since construction
    /// Entries of earlier epochs stay in place until they are overwritten: no key leads to them any more.
    void next_epoch() {
        bits_.set_epoch(++epoch_);
        is_current_.assign(bits_.slots(), false);
    }
    /// Copies the occupied slots in order to `entries`, which has room for bits().occupied() of them. Not
    /// safe while a frame ends.
    void read(std::span<KeptEntry> entries) const {
        auto next = entries.begin();
        for (size_t slot = 0; slot < bits_.slots(); ++slot)
            if (const uint32_t word = bits_.word(slot))
                *next++ = {uint32_t(slot), word >> 1, bool(word & 1),
                           is_current_.empty() || is_current_[slot]};
    }

    void begin_frame() { waiting_.clear(); }
    /// Takes the writes of a tile. Threads may call this at once for different tiles.
    void keep(size_t tile, std::vector<PackedWrite>& writes) {
        const std::lock_guard lock(mutex_);
        waiting_[tile].swap(writes);
    }
    void end_frame(Counters& counters) {
        TableCounts counts;
        // In the order of tiles: the last write to a slot wins, whichever thread came first.
        for (const auto& [tile, writes] : waiting_)
            for (PackedWrite w : writes) {
                const KeyHash h{uint32_t(w >> 32), uint32_t(w) >> 1};
                bits_.put_hashed(h, w & 1, counts);
                // In the first epoch all entries are current and no flags are kept.
                if (epoch_) is_current_[bits_.slot(h)] = true;
            }
        waiting_.clear();
        ++frames_;
        counters.add_writes(counts.writes, counts.evictions, counts.duplicates, counts.expected_false_hits);
        counters.table_slots = bits_.slots();
        counters.table_occupied = bits_.occupied();
    }

private:
    BitTable bits_;
    std::vector<bool> is_current_;  ///< slots written in this epoch; empty in the first epoch, when all are
    uint64_t epoch_ = 0, frames_ = 0;
    std::mutex mutex_;
    std::map<size_t, std::vector<PackedWrite>> waiting_;
};

/// The table of a tile on top of the kept table.
class LayeredTable {
public:
    LayeredTable(BitTable& own, const BitTable& kept, std::vector<PackedWrite>& writes)
        : own_(own), kept_(kept), writes_(writes) {}
    KeyHead head(const std::array<int32_t, 8>& slots) const { return kept_.head(slots); }
    std::optional<bool> get(const KeyHead& head, const FarKey& far) const {
        // One hash for both tables: they differ only in size.
        const KeyHash h = kept_.hash(head, far);
        const auto own = own_.get_hashed(h);
        // The tile's own bits are newer.
        last_is_kept_ = !own;
        return own ? own : kept_.get_hashed(h);
    }
    void put(const FullKey& key, bool visible, TableCounts&) {
        const KeyHash h = kept_.hash(key);
        TableCounts of_the_tile;  // not reported: these writes end with the tile
        own_.put_hashed(h, visible, of_the_tile);
        writes_.push_back(pack_write(h, visible));
    }
    uint64_t slots() const { return 0; }
    /// True if the last answer of `get` came from an earlier frame.
    bool last_is_kept() const { return last_is_kept_; }

private:
    BitTable& own_;
    const BitTable& kept_;
    std::vector<PackedWrite>& writes_;
    mutable bool last_is_kept_ = false;
};

}  // namespace viscache

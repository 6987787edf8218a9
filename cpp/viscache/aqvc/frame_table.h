#pragma once
// One table for all threads of a frame (AQVC Sec. 4.1), for bidirectional path tracing.
//
// Batched: the table is read-only during a round. Each item keeps its writes, and they are applied between
// rounds in the order of the items. The values do not depend on the number of threads. Items of one round can
// trace the same cluster (`Counters::duplicates`).
//
// Racing: all threads read and write at any time through relaxed atomics. Which segment is traced for a
// cluster depends on timing.
#include <optional>
#include <vector>

#include "viscache/aqvc/bit_table.h"
#include "viscache/visibility/counters.h"

namespace viscache {

struct TableWrite {
    FullKey key;
    bool visible;
};

/// View of a table for one item of a round: reads go to the table, writes are deferred.
template <class Table>
class DeferredTable {
public:
    DeferredTable(const Table& table, std::vector<TableWrite>& writes) : table_(table), writes_(writes) {}
    KeyHead head(const std::array<int32_t, 8>& slots) const { return table_.head(slots); }
    std::optional<bool> get(const KeyHead& head, const FarKey& far) const { return table_.get(head, far); }
    void put(const FullKey& key, bool visible, TableCounts&) { writes_.push_back({key, visible}); }
    uint64_t slots() const { return table_.slots(); }

private:
    const Table& table_;
    std::vector<TableWrite>& writes_;
};

/// [AQVC Sec. 4.2] The table that all threads of bidirectional path tracing share. Its keys follow Eq. 6,
/// without refinement.
// Differs (A54): the threads of the paper race. Here that is Storage::kShared.
class FrameTable {
public:
    explicit FrameTable(const AqvcParameters& p) {
        detail::require(p.queue == 0, "queue must be 0 with one table for the frame (Bdpt)", p.queue);
        const uint64_t slots = largest_prime(p.table_bytes / 4);
        switch (p.storage) {
            case Storage::kTable: table_.emplace(slots, p.digest_bits, p.hash); break;
            case Storage::kExact: exact_.emplace(); break;
            case Storage::kShared: racing_.emplace(slots, p.digest_bits, p.hash); break;
            case Storage::kPaperTiles:
                throw std::invalid_argument(
                    "storage must be table, exact or shared with one table for the frame (Bdpt), got "
                    "paper_tiles");
        }
    }
    void begin_round(size_t items) { waiting_.resize(std::max(items, waiting_.size())); }
    /// Takes the writes of an item. Threads may call this at once for different items.
    // Swapped, so that the item's next writes reuse the memory of earlier ones.
    void keep(size_t item, std::vector<TableWrite>& writes) {
        waiting_[item].swap(writes);
        writes.clear();
    }
    /// Applies the deferred writes in order. Called by one thread while no other uses the table.
    void end_round(Counters& counters) {
        TableCounts counts;
        for (auto& writes : waiting_) {
            for (const TableWrite& w : writes)
                table_ ? table_->put(w.key, w.visible, counts) : exact_->put(w.key, w.visible, counts);
            writes.clear();
        }
        counters.add_writes(counts.writes, counts.evictions, counts.duplicates, counts.expected_false_hits);
        counters.table_slots = visit([](const auto& t) { return t.slots(); });
        counters.table_occupied = visit([](const auto& t) { return t.occupied(); });
    }

    /// Calls `use` with the view of one item, whose deferred writes go to `writes`.
    template <class Use>
    void with_table(std::vector<TableWrite>& writes, Use use) {
        // Racing tables write at once: there is nothing to defer.
        if (racing_) return use(*racing_);
        if (exact_) {
            DeferredTable view(*exact_, writes);
            return use(view);
        }
        DeferredTable view(*table_, writes);
        use(view);
    }

private:
    template <class Use>
    uint64_t visit(Use use) const {
        return racing_ ? use(*racing_) : exact_ ? use(*exact_) : use(*table_);
    }

    std::optional<BitTable> table_;  ///< one of the three is set
    std::optional<ExactTable> exact_;
    std::optional<RacingBitTable> racing_;
    std::vector<std::vector<TableWrite>> waiting_;
};

}  // namespace viscache

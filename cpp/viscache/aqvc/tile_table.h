#pragma once
// Numbers the cells of the eye points of a tile, so that visibility is stored as dense bit rows: one row per
// cell, one column per far end.
#include <cstdint>
#include <vector>

#include "viscache/aqvc/cluster_key.h"

namespace viscache {

constexpr uint32_t kNoCell = 0xffffffffu;

/// Numbers cells in the order of first use. The tag separates equal cells that must not share a row.
class CellNumbers {
public:
    void clear() {
        cells_.clear();
        // A power of two, for the mask in `locate`
        if (slots_.size() < 1024) slots_.resize(1024);
        std::fill(slots_.begin(), slots_.end(), 0u);
    }
    size_t size() const { return cells_.size(); }
    const Cell& operator[](size_t i) const { return cells_[i].cell; }
    uint32_t tag(size_t i) const { return cells_[i].tag; }

    uint32_t find(const Cell& cell, uint32_t tag) const {
        const uint32_t entry = slots_[locate(cell, tag)];
        return entry ? entry - 1 : kNoCell;
    }
    /// The number of a cell; a new cell gets the next number.
    uint32_t number(const Cell& cell, uint32_t tag) {
        const size_t at = locate(cell, tag);
        if (slots_[at]) return slots_[at] - 1;
        cells_.push_back({cell, tag});
        slots_[at] = uint32_t(cells_.size());
        if (2 * cells_.size() > slots_.size()) grow();
        return uint32_t(cells_.size() - 1);
    }

    /// Keeps the first `count` cells.
    /// For taking back: later cells vanish, numbers of earlier ones stay.
    void truncate(size_t count) {
        if (count >= cells_.size()) return;
        cells_.resize(count);
        index();
    }

private:
    struct Entry {
        Cell cell;
        uint32_t tag;
    };
    // All coordinates are mixed by multiplications with odd constants, since neighbouring cells differ in few
    // bits.
    static uint64_t hash(const Cell& c, uint32_t tag) {
        uint64_t h = uint64_t(c.x) * 0x9e3779b97f4a7c15ull + uint64_t(c.y) * 0xc2b2ae3d27d4eb4full;
        h ^= h >> 29;
        h = (h + uint64_t(c.z)) * 0xff51afd7ed558ccdull +
            (uint64_t(uint32_t(c.bin)) << 32 | uint32_t(c.slot)) + tag;
        h ^= h >> 32;
        h *= 0xc4ceb9fe1a85ec53ull;
        return h ^ h >> 29;
    }
    // Linear probing: ends at the cell or at the free slot for it. At most half the slots are in use.
    size_t locate(const Cell& cell, uint32_t tag) const {
        const size_t mask = slots_.size() - 1;
        size_t i = size_t(hash(cell, tag)) & mask;
        while (slots_[i] && !(cells_[slots_[i] - 1].tag == tag && cells_[slots_[i] - 1].cell == cell))
            i = (i + 1) & mask;
        return i;
    }
    void grow() {
        slots_.resize(2 * slots_.size());
        index();
    }
    void index() {
        // Without cells that were removed: an entry taken out of its probing run would hide those behind it.
        std::fill(slots_.begin(), slots_.end(), 0u);
        const size_t mask = slots_.size() - 1;
        for (size_t k = 0; k < cells_.size(); ++k) {
            size_t i = size_t(hash(cells_[k].cell, cells_[k].tag)) & mask;
            while (slots_[i]) i = (i + 1) & mask;
            slots_[i] = uint32_t(k + 1);
        }
    }
    std::vector<Entry> cells_;
    std::vector<uint32_t> slots_;  ///< number + 1; 0 = free
};

}  // namespace viscache

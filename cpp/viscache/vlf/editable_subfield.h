#pragma once
// A subfield whose lists are changed in place.
#include <cstdint>
#include <span>
#include <vector>

#include "viscache/vlf/subfield.h"

namespace viscache {

/// Lists with spare capacity in one pool. A list that exceeds its capacity moves to the end of the pool.
/// When too much of the pool is unused, all lists are laid out again.
///
/// The borders of leaves stay as they were built, so that a triangle is removed from the leaves into which
/// it was inserted. Depths beyond the range belong to the outermost leaves. A tile that was empty has one
/// leaf.
class EditableSubfield {
public:
    explicit EditableSubfield(const Subfield& built);

    // Interface of a layer for walk_field
    TileRect rect;
    TileBsp bsp(size_t tile) const {
        const Tile& t = tiles_[tile];
        TileBsp b{t.slabs.z0, t.slabs.z1, int(t.leaves), nullptr};
        if (!borders_.empty() && b.leaves > 1) b.borders = borders_.data() + t.first_leaf;
        return b;
    }
    Subfield::Range occupied(size_t tile) const { return tiles_[tile].occupied; }
    std::span<const uint32_t> leaf(size_t tile, int l) const {
        const List& list = lists_[tiles_[tile].first_leaf + size_t(l)];
        return {ids_.data() + list.first, list.count};
    }

    /// Adds a triangle to the leaves of the tile between its depths.
    void insert(size_t tile, const TileEntry& entry);
    /// Removes a triangle, given the entry with which it was inserted or built.
    void remove(size_t tile, const TileEntry& entry);
    uint64_t bytes() const {
        return sizeof(Tile) * tiles_.size() + sizeof(List) * lists_.size() + sizeof(uint32_t) * ids_.size() +
               sizeof(float) * borders_.size();
    }

private:
    // `slabs` divides the depth into leaves and never changes; `occupied` bounds what is listed.
    struct Tile {
        uint32_t first_leaf, leaves;
        Subfield::Range slabs, occupied;
    };
    // `room` entries from `first` on, `count` of them in use.
    struct List {
        uint32_t first, count, room;
    };
    void add(List& list, uint32_t id);
    void lay_out_anew();

    std::vector<Tile> tiles_;
    std::vector<List> lists_;
    std::vector<uint32_t> ids_;
    std::vector<float> borders_;
    size_t left_over_ = 0;  ///< unused entries of the pool
};

}  // namespace viscache

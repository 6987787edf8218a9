#pragma once
// A subfield whose lists change in place.
#include <cstdint>
#include <span>
#include <vector>

#include "viscache/vlf/subfield.h"

namespace viscache {

/// Lists with room to grow in one pool. A list that outgrows its room moves to the pool's end; when too much
/// of the pool is left over, all lists are laid out anew.
///
/// Where a tile is cut stays as it was built, so that a triangle leaves the leaves it was put into; depths
/// beyond belong to the outermost leaves. Tiles that were empty have one leaf.
class EditableSubfield {
public:
    explicit EditableSubfield(const Subfield& built);

    // A layer of walk_field
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

    /// Lists a triangle in the tile's leaves between its depths.
    void insert(size_t tile, const TileEntry& entry);
    /// Takes out what `insert` put in, or what the subfield was built with, given the same entry.
    void remove(size_t tile, const TileEntry& entry);
    uint64_t bytes() const {
        return sizeof(Tile) * tiles_.size() + sizeof(List) * lists_.size() + sizeof(uint32_t) * ids_.size() +
               sizeof(float) * borders_.size();
    }

private:
    struct Tile {
        uint32_t first_leaf, leaves;
        Subfield::Range slabs, occupied;
    };
    struct List {
        uint32_t first, count, room;
    };
    void add(List& list, uint32_t id);
    void lay_out_anew();

    std::vector<Tile> tiles_;
    std::vector<List> lists_;
    std::vector<uint32_t> ids_;
    std::vector<float> borders_;
    size_t left_over_ = 0;  ///< of the pool
};

}  // namespace viscache

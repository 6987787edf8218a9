#include "viscache/vlf/editable_subfield.h"

#include <limits>
#include <stdexcept>

namespace viscache {

namespace {

/// Capacity of a new list with `count` entries.
// A quarter more, so that a list moves to the end of the pool only after many insertions; at least one entry.
uint32_t room_for(uint32_t count) { return count + count / 4 + 1; }

}  // namespace

EditableSubfield::EditableSubfield(const Subfield& built) : rect(built.rect) {
    for (size_t i = 0; i < built.tiles(); ++i) {
        const TileBsp b = built.bsp(i);
        tiles_.push_back({uint32_t(lists_.size()), uint32_t(b.leaves), {b.z0, b.z1}, built.occupied(i)});
        if (b.borders) {
            // `borders_` has the same indices as the lists: leaf l of a tile starts at the border of its
            // list. Tiles of one leaf leave a gap.
            borders_.resize(lists_.size());  // if any tile has borders, as long as the lists
            borders_.insert(borders_.end(), b.borders, b.borders + b.leaves);
        }
        for (int l = 0; l < b.leaves; ++l) {
            const auto ids = built.leaf(i, l);
            const uint32_t count = uint32_t(ids.size()), room = room_for(count);
            lists_.push_back({uint32_t(ids_.size()), count, room});
            ids_.insert(ids_.end(), ids.begin(), ids.end());
            ids_.resize(ids_.size() + room - count);
        }
    }
}

/// Lists lie in one pool, each with free entries (.) behind it. A full list moves to the end of the pool:
///
///     [a b c .][d e][f g .]    +x to the second    [a b c .][- -][f g .][d e x]
void EditableSubfield::add(List& list, uint32_t id) {
    if (list.count == list.room) {
        const uint32_t room = room_for(list.room), first = uint32_t(ids_.size());
        // Offsets have 32 bits.
        if (ids_.size() + room > std::numeric_limits<uint32_t>::max())
            throw std::length_error("a subfield lists at most 2^32 - 2 triangles, n_tiles is too large");
        ids_.resize(ids_.size() + room);
        std::copy_n(ids_.begin() + list.first, list.count, ids_.begin() + first);
        left_over_ += list.room;
        list.first = first;
        list.room = room;
    }
    // Ids ascend, as in a subfield that was built: the order of insertions does not show.
    const auto begin = ids_.begin() + list.first, end = begin + list.count;
    const auto place = std::lower_bound(begin, end, id);
    std::move_backward(place, end, end + 1);
    *place = id;
    ++list.count;
}

void EditableSubfield::insert(size_t tile, const TileEntry& entry) {
    Tile& t = tiles_[tile];
    // The only leaf of a tile that was empty. Its range is that of the first entry and stays so: later depths
    // beyond it belong to the same leaf.
    if (t.leaves == 0) {
        t = {uint32_t(lists_.size()), 1, {entry.low, entry.high}, {entry.low, entry.high}};
        lists_.push_back({uint32_t(ids_.size()), 0, 0});
    }
    // Grows only: removals leave it too large, which costs a visit and loses no hit.
    t.occupied = {std::min(t.occupied.z0, entry.low), std::max(t.occupied.z1, entry.high)};
    const TileBsp b = bsp(tile);
    for (int l = b.leaf_of(entry.low), last = b.leaf_of(entry.high); l <= last; ++l)
        add(lists_[t.first_leaf + size_t(l)], entry.id);
    // Three tenths of the pool are abandoned lists.
    if (left_over_ * 10 > ids_.size() * 3) lay_out_anew();
}

void EditableSubfield::remove(size_t tile, const TileEntry& entry) {
    const TileBsp b = bsp(tile);
    for (int l = b.leaf_of(entry.low), last = b.leaf_of(entry.high); l <= last; ++l) {
        List& list = lists_[tiles_[tile].first_leaf + size_t(l)];
        const auto begin = ids_.begin() + list.first, end = begin + list.count;
        const auto place = std::lower_bound(begin, end, entry.id);
        if (place == end || *place != entry.id)
            throw std::logic_error("a triangle is not in the tile it should leave");
        std::move(place + 1, end, place);
        --list.count;
    }
}

void EditableSubfield::lay_out_anew() {
    std::vector<uint32_t> ids;
    for (List& list : lists_) {
        const uint32_t first = uint32_t(ids.size());
        ids.insert(ids.end(), ids_.begin() + list.first, ids_.begin() + list.first + list.count);
        list = {first, list.count, room_for(list.count)};
        ids.resize(first + size_t(list.room));
    }
    ids_ = std::move(ids);
    left_over_ = 0;
}

}  // namespace viscache

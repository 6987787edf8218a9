#pragma once
// Exact half-open bins over distance and angle. A distance or angle is mapped to a 32-bit key that increases
// with it. An edge is the smallest key at or above it. A table gives the bin of a key.
#include <bit>
#include <cstdint>
#include <span>
#include <vector>

namespace viscache {

/// Key that increases with a squared distance, a float >= 0.
inline uint32_t distance_key(float squared_distance) { return std::bit_cast<uint32_t>(squared_distance); }
/// Key that increases with the squared chord |n − n'|² of two unit normals, a float in [0, 4]. Its
/// resolution near 4 is as fine as near 0.
inline uint32_t chord_key(float squared_chord) {
    if (squared_chord < 2) return std::bit_cast<uint32_t>(squared_chord);
    return 0x80000000u - std::bit_cast<uint32_t>(4 - (squared_chord < 4 ? squared_chord : 4.f));
}

/// Table that gives the code of a key: the number of edges at or below it. Code 0 lies before the first
/// edge; the number of edges lies at or past the last.
///
/// The keys are divided into cells with at most one edge each. Let `low` be the offset of the key in its
/// cell and `edge` the offset of the edge. The entry of a cell is code·2¹⁷ + (2¹⁷ − edge) − (key − low).
/// Adding the key gives code·2¹⁷ + 2¹⁷ + (low − edge), whose upper bits are code + 1 if low >= edge.
///
///                    low ->|
///     |----- edge ---------+-----------|      one cell: before its edge `code`, at or past it `code` + 1
///     ^ key − low
struct KeyTable {
    static constexpr int kCodeShift = 17;
    static constexpr uint32_t kNoEdge = 1u << kCodeShift;

    // Keys before the first cell or past the last have the code of these cells, which hold no edge.
    uint32_t code(uint32_t key) const {
        const uint32_t k = key < first_key ? first_key : key > last_key ? last_key : key;
        return (entries[(k >> shift) - (first_key >> shift)] + k) >> kCodeShift;
    }
    /// Address that the entry of cell 0 would have, for gathers indexed by k >> shift.
    const uint32_t* origin() const {
        return reinterpret_cast<const uint32_t*>(reinterpret_cast<uintptr_t>(entries) -
                                                 sizeof(uint32_t) * (first_key >> shift));
    }

    const uint32_t* entries = nullptr;
    int shift = 0;
    uint32_t first_key = 0, last_key = 0;  ///< start of the first and of the last cell, which hold no edge
};

class BinEdges {
public:
    /// Bins of distance. A pair is at or past an edge if d² (in float) is >= the square of the edge (in
    /// double). The last edge may be infinite.
    static BinEdges distances(std::span<const double> edges);
    /// Bins of the angle between normals; edges in degrees in [0, 180]. A pair is at or past an edge if its
    /// squared chord (in float) is >= 4 sin²(edge/2) (in double). An edge of 180 includes opposite normals
    /// in the last bin.
    static BinEdges angles(std::span<const double> edges_deg);

    size_t bins() const { return keys_.size() - 1; }
    KeyTable table() const {
        const auto last = first_cell_ + uint32_t(entries_.size()) - 1;
        return {entries_.data(), shift_, first_cell_ << shift_, last << shift_};
    }

private:
    BinEdges(std::vector<uint32_t> keys, const char* name);
    void build(const char* name);

    std::vector<uint32_t> keys_, entries_;
    int shift_ = 0;
    uint32_t first_cell_ = 0;
};

}  // namespace viscache

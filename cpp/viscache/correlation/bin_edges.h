#pragma once
// Half-open bins over distance and angle, found exactly: the place of a pair is a key of 32 bits that grows
// with it, an edge is the smallest key that lies at or past it, and a table finds the bin of a key.
#include <bit>
#include <cstdint>
#include <span>
#include <vector>

namespace viscache {

/// Grows with a squared distance, a float >= 0.
inline uint32_t distance_key(float squared_distance) { return std::bit_cast<uint32_t>(squared_distance); }
/// Grows with the squared chord |n − n'|² of two unit normals, a float in [0, 4]; as fine near 4 as near 0.
inline uint32_t chord_key(float squared_chord) {
    if (squared_chord < 2) return std::bit_cast<uint32_t>(squared_chord);
    const float rest = 4 - squared_chord;
    return 0x80000000u - std::bit_cast<uint32_t>(rest > 0 ? rest : 0.f);
}

/// What a kernel needs to find the code of a key, the number of edges at or below it: 0 lies before the first
/// edge, the number of edges past the last.
struct KeyTable {
    const uint32_t* entries = nullptr;  ///< of every cell: code at its start << 17 | low bits of its edge
    int shift = 0, base = 0, last = 0;  ///< cell = clamp((key >> shift) − base, 0, last)

    static constexpr int kCodeShift = 17;
    static constexpr uint32_t kEdgeMask = (1u << kCodeShift) - 1, kNoEdge = kEdgeMask;

    uint32_t low_mask() const { return (1u << shift) - 1; }
    uint32_t code(uint32_t key) const {
        const int cell = int(key >> shift) - base;
        const uint32_t entry = entries[cell < 0 ? 0 : cell > last ? last : cell];
        return (entry >> kCodeShift) + ((key & low_mask()) >= (entry & kEdgeMask));
    }
};

class BinEdges {
public:
    /// Bins of distance: a pair lies at or past an edge if d², in float, is >= the square of the edge, in
    /// double. The last edge may be infinite.
    static BinEdges distances(std::span<const double> edges);
    /// Bins of the angle between normals, in degrees in [0, 180]: a pair lies at or past an edge if its
    /// squared chord, in float, is >= 4 sin²(edge/2), in double. An edge of 180 closes the last bin.
    static BinEdges angles(std::span<const double> edges_deg);

    size_t bins() const { return keys_.size() - 1; }
    KeyTable table() const { return {entries_.data(), shift_, base_, int(entries_.size()) - 1}; }

private:
    BinEdges(std::vector<uint32_t> keys, const char* name);
    void build(const char* name);

    std::vector<uint32_t> keys_, entries_;
    int shift_ = 0, base_ = 0;
};

}  // namespace viscache

#pragma once
// The map of a record: 2^m × 2^m cells of the equal-area octahedral map of the whole sphere, one bit per
// cell, 1 = free, along the Z-order curve. A word is a block of 8×8 cells; above the words is a quadtree of
// two-bit codes.
#include "viscache/vismap/blended_maps.h"

namespace viscache {

constexpr int kMinMapLog2 = 4, kMaxMapLog2 = 7;  ///< range of m
/// Position, normal, rays, misses, last-used frame.
constexpr size_t kRecordHeadBytes = 36;

constexpr size_t map_cells(int m) { return size_t{1} << (2 * m); }
constexpr size_t map_words(int m) { return map_cells(m) / kWordBits; }
/// Number of nodes above a level of the quadtree; the root is level 0.
/// The levels of a map of m = 5, 42 bits in one word:
///
///     level 0    1 node  of 32 × 32 cells        codes     0
///     level 1    4 nodes of 16 × 16              codes     1 ...  4
///     level 2   16 nodes of  8 × 8 = words       codes     5 ... 20
constexpr size_t nodes_above(int level) { return ((size_t{1} << (2 * level)) - 1) / 3; }
/// Number of nodes with a stored code: levels 0 to m − 3.
constexpr size_t hierarchy_nodes(int m) { return nodes_above(m - 2); }
constexpr size_t hierarchy_words(int m) { return (2 * hierarchy_nodes(m) + kWordBits - 1) / kWordBits; }
/// Bytes of a record as counted in the paper: map, hierarchy and head.
constexpr size_t record_nbytes(int m) {
    return (map_words(m) + hierarchy_words(m)) * sizeof(Word) + kRecordHeadBytes;
}

/// State of the cells of a node: bit 0 = any cell is free, bit 1 = all cells are free.
enum NodeCode : uint8_t { kBlocked = 0, kPartial = 1, kFree = 3 };

/// Code of a node of levels 0 to m − 3; `index` runs along the Z-order curve.
inline NodeCode stored_code(const Word* hierarchy, int level, uint32_t index) {
    const size_t bit = 2 * (nodes_above(level) + index);
    return NodeCode(hierarchy[bit / kWordBits] >> (bit % kWordBits) & 3);
}

/// Code of any node, down to single cells (level m).
inline NodeCode node_code(int m, const Word* bits, const Word* hierarchy, int level, uint32_t index) {
    const int edge_log2 = m - level;
    if (edge_log2 >= 3) return stored_code(hierarchy, level, index);
    // Below the level of words, a node is a run of 1, 4 or 16 bits
    const size_t cells = size_t{1} << (2 * edge_log2), first = index * cells;
    const Word all = (Word{1} << cells) - 1;
    // 1, 4 or 16 bits: such a run never crosses a word.
    const Word part = bits[first / kWordBits] >> (first % kWordBits) & all;
    return part == 0 ? kBlocked : part == all ? kFree : kPartial;
}

/// Computes the codes of levels m − 3 up to the root. A parent is free if all its children are free, and
/// blocked if all are blocked.
inline void build_hierarchy(int m, const Word* bits, Word* hierarchy) {
    std::memset(hierarchy, 0, hierarchy_words(m) * sizeof(Word));
    const auto store = [&](int level, uint32_t index, unsigned code) {
        const size_t bit = 2 * (nodes_above(level) + index);
        hierarchy[bit / kWordBits] |= Word{code} << (bit % kWordBits);
    };
    for (uint32_t w = 0; w < map_words(m); ++w)
        // A node of the last stored level is one word.
        store(m - 3, w, bits[w] == 0 ? kBlocked : bits[w] == ~Word{0} ? kFree : kPartial);
    for (int level = m - 4; level >= 0; --level)
        for (uint32_t i = 0; i < uint32_t(1) << (2 * level); ++i) {
            unsigned any = 0, all = kFree;
            for (uint32_t child = 4 * i; child < 4 * i + 4; ++child) {
                const unsigned code = stored_code(hierarchy, level + 1, child);
                any |= code;
                // Bit 0 says "any", bit 1 says "all": the parent's bits are OR and AND of the children's.
                all &= code;
            }
            store(level, i, (any & 1) | (all & 2));
        }
}

}  // namespace viscache

#pragma once
// Adaptive refinement, one query at a time (AQVC Sec. 3.6).
#include <array>
#include <span>
#include <vector>

#include "viscache/aqvc/hash.h"
#include "viscache/visibility/counters.h"

namespace viscache {

/// The cells of one point at the levels of C_E, from coarse to fine. A level with the same cell as the level
/// before is left out.
struct CellLevels {
    // Heads of keys are hashed once per cell, not once per query.
    struct Level {
        PlacedCell placed;
        int level = 0;        ///< index in the list of C_E
        bool probed = false;  ///< the heads of the neighbours are known
        KeyHead own{};
        std::array<KeyHead, 4> neighbours{};
    };
    Anchor anchor;
    Semantic semantic = Semantic::kPoint;
    std::vector<Level> levels;

    template <class Table>
    void add(const Table& table, const CellGrid& grid, const PlacedCell& placed, int level) {
        levels.push_back({placed, level, false, table.head(grid.head_slots(semantic, placed.cell)), {}});
    }
    // Heads of neighbours are made at the first probe; many cells never need them.
    template <class Table>
    void make_neighbours(const Table& table, const CellGrid& grid, Level& at) const {
        for (size_t q = 0; q < 4; ++q) {
            const auto [dx, dy] = kNeighbourOffsets[q];
            const Cell cell = grid.neighbour(anchor, at.placed, dx, dy);
            at.neighbours[q] = table.head(grid.head_slots(semantic, cell));
        }
        at.probed = true;
    }
    bool repeats(const PlacedCell& placed) const {
        return !levels.empty() && levels.back().placed.cell == placed.cell;
    }
};

/// Result of the cache for one query.
struct Walk {
    bool known = false;
    bool visible = false;  ///< valid if known
    int level = 0;         ///< level at which the walk ended; a new ray counts for it
    bool kept = false;     ///< the value comes from an earlier frame
    FullKey key{};         ///< key of the cell at that level; set if the value is unknown or kept
};

/// [AQVC Alg. 2] Looks up a query from coarse to fine. The walk ends at the first empty cluster, whose ray is
/// then the query's own segment. It also ends at a value with which the four neighbour clusters agree (nil
/// agrees). The finest value is always used.
// Differs (A53): neighbours are not probed at the finest level, because the loop of the paper ends there in
// any case. `fars` holds one key for all levels (Eq. 7) or one per level (Eq. 6).
template <class Table>
Walk walk_levels(const Table& table, const CellGrid& grid, CellLevels& eye, std::span<const FarKey> fars,
                 Counters& counters) {
    Walk walk;
    for (size_t d = 0; d < eye.levels.size(); ++d) {
        CellLevels::Level& at = eye.levels[d];
        const FarKey& far = fars[fars.size() == 1 ? 0 : d];
        walk.level = at.level;
        const auto value = table.get(at.own, far);
        ++counters.lookups;
        // Nil ends the walk: the query's own ray becomes the cluster's bit. It is exact for this query.
        walk.known = value.has_value();
        if (!walk.known) {
            walk.key = CellGrid::full_key(at.own.slots, far);
            return walk;
        }
        ++counters.hits;
        walk.visible = *value;
        if constexpr (requires { table.last_is_kept(); }) {
            walk.kept = table.last_is_kept();
            if (walk.kept) walk.key = CellGrid::full_key(at.own.slots, far);
        }
        // The finest level: nothing finer to go to, so neighbours need not be asked.
        if (d + 1 == eye.levels.size()) return walk;
        if (!at.probed) eye.make_neighbours(table, grid, at);
        bool agree = true;
        for (const KeyHead& neighbour : at.neighbours) {
            const auto other = table.get(neighbour, far);
            ++counters.neighbour_probes;
            counters.nil_neighbours += !other;
            // An empty neighbour does not disagree.
            if (other && *other != walk.visible) agree = false;
        }
        if (agree) return walk;
        counters.boundary_queries += d + 2 == eye.levels.size();
    }
    return walk;
}

}  // namespace viscache

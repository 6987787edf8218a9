#pragma once
// Adaptive refinement, one query at a time (AQVC Sec. 3.6).
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "viscache/aqvc/hash.h"
#include "viscache/visibility/counters.h"

namespace viscache {

/// The cells of one point at every level of C_E, coarse to fine; a level whose cell equals the one before is
/// left out.
struct CellLevels {
    struct Level {
        PlacedCell placed;
        int level = 0;        ///< index into the list of C_E
        bool probed = false;  ///< the heads of the neighbours are made when first needed
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

/// What the cache says about one query.
struct Walk {
    bool known = false;
    bool visible = false;  ///< if known
    int level = 0;         ///< where the walk ended: a new ray belongs to this level
    bool kept = false;     ///< the value is from a frame before
    FullKey key{};         ///< of that cell, if not known or from a frame before
};

/// [AQVC Alg. 2] Looks the query up from coarse to fine. The first empty cluster ends the walk: its ray is
/// the query's own segment. A value on which the four neighbour clusters agree (nil agrees) ends it too; the
/// finest is taken as it is.
// Differs: nothing is probed at the finest level, where the paper's loop ends whatever the neighbours say.
// `fars` holds one key for all levels (Eq. 7) or one per level (Eq. 6).
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
        if (d + 1 == eye.levels.size()) return walk;
        if (!at.probed) eye.make_neighbours(table, grid, at);
        bool agree = true;
        for (const KeyHead& neighbour : at.neighbours) {
            const auto other = table.get(neighbour, far);
            ++counters.neighbour_probes;
            counters.nil_neighbours += !other;
            if (other && *other != walk.visible) agree = false;
        }
        if (agree) return walk;
        counters.boundary_queries += d + 2 == eye.levels.size();
    }
    return walk;
}

}  // namespace viscache

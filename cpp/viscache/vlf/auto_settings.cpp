#include "viscache/vlf/auto_settings.h"

#include "viscache/casters/bsp_tree.h"

namespace viscache {

namespace {

// Counts of the half octahedron: 2·4^k + 1 axes, or the vertical one. 8193 is left to users: with 128² tiles,
// the records of the tiles take 2 GB.
constexpr uint32_t kCounts[] = {1, 3, 9, 33, 129, 513, 2049};
constexpr int kTiles[] = {1, 2, 4, 8, 16, 32, 64, 128, 256, 512};
constexpr int kDepths[] = {5, 4, 3, 2, 1, 0};  // of equal costs the deepest wins: few tiles pay for the depth

/// Mean angle to the nearest of l axes: 2.46° at 513 axes, half as much at four times as many.
double mean_angle(uint32_t n_directions) { return 2.46 * kPi / 180 * std::sqrt(513.0 / n_directions); }

/// A rough estimate of the bytes. The prediction decides in the end.
double rough_bytes(const FieldTriangles& triangles, const FieldSettings& s, double references) {
    const double tiles = double(s.n_tiles) * s.n_tiles;
    // A tile is split until its leaves hold `leaf_target` triangles, so there is about one leaf per
    // `leaf_target` references beyond one per tile.
    const double leaves =
        std::min(tiles * (1 << s.bsp_depth), tiles + references / std::max(1, s.leaf_target));
    return double(triangles.bytes()) + s.n_directions * (16 * tiles + 4 * leaves + 4 * references);
}

/// The two terms that dominate: entering references, and setting up tiles.
double build_s(const FieldSettings& s, double references) {
    return s.n_directions * (75e-9 * references + 27e-9 * s.n_tiles * s.n_tiles);
}

struct Candidate {
    FieldSettings settings;
    double cost;
};

std::vector<Candidate> candidate_settings(const FieldTriangles& triangles, const FieldSettings& given) {
    std::vector<Candidate> found;
    for (const int n : kTiles) {
        // A given value replaces the whole list: the loop ends after its first entry.
        if (given.n_tiles != 0 && n != kTiles[0]) break;
        FieldSettings s = given;
        if (given.n_tiles == 0) s.n_tiles = n;
        const double references = expected_references(triangles.in_ball(), s.n_tiles);
        for (const uint32_t l : kCounts)
            for (const int depth : kDepths) {
                if ((given.n_directions != 0 && l != kCounts[0]) ||
                    (given.bsp_depth >= 0 && depth != kDepths[0]))
                    continue;
                if (given.n_directions == 0) s.n_directions = l;
                if (given.bsp_depth < 0) s.bsp_depth = depth;
                // Only clear excess is dropped here; close cases are left to the exact prediction.
                if (rough_bytes(triangles, s, references) > 1.5 * double(s.max_bytes)) continue;
                if (s.max_build_s > 0 && build_s(s, references) > s.max_build_s) continue;
                found.push_back({s, expected_cost(triangles, s).total()});
            }
    }
    // Stable, so equal costs keep the order of the lists, the deepest tiles first.
    std::stable_sort(found.begin(), found.end(),
                     [](const Candidate& a, const Candidate& b) { return a.cost < b.cost; });
    return found;
}

}  // namespace

FieldCost expected_cost(const FieldTriangles& triangles, const FieldSettings& s) {
    const double tiles = 1 + 4 / kPi * (4.0 / 3) * std::sin(mean_angle(s.n_directions)) * s.n_tiles / 2;
    // About a disc of tiles is not empty
    // 0.785 = π/4: the disc's share of its square.
    const double listed =
        expected_references(triangles.in_ball(), s.n_tiles) / std::max(1.0, 0.785 * s.n_tiles * s.n_tiles);
    const double leaves = 1 << tile_depth(size_t(std::ceil(listed)), s.bsp_depth, s.leaf_target);
    // Crossing the tiles, a ray passes the leaves of one tile once, plus one leaf per further tile
    const double visited = std::min(leaves * tiles, leaves + tiles);
    return {tiles, visited * listed / leaves};
}

double expected_build_s(const FieldTriangles& triangles, const FieldSettings& s) {
    return build_s(s, expected_references(triangles.in_ball(), s.n_tiles));
}

FieldSettings chosen_settings(const FieldTriangles& triangles, const FieldSettings& given, int threads,
                              const Control& control) {
    const bool open = given.n_directions == 0 || given.n_tiles == 0 || given.bsp_depth < 0;
    if (!open) return given;
    // Candidates are sorted by cost, so the first one that fits is the cheapest. The exact prediction builds
    // a few subfields; few candidates need it.
    // A lazy field keeps only as many subfields as fit
    for (const Candidate& c : candidate_settings(triangles, given))
        if (given.lazy || predicted_peak(triangles, c.settings, threads, control).peak() <= given.max_bytes)
            return c.settings;
    FieldSettings least = given;
    if (given.n_directions == 0) least.n_directions = kCounts[0];
    if (given.n_tiles == 0) least.n_tiles = kTiles[0];
    if (given.bsp_depth < 0) least.bsp_depth = 0;
    return least;  // if even this is too large, check_budget reports it
}

}  // namespace viscache

#pragma once
// Statistics of ρ over all pairs of points, or over the pairs of selected tiles.
#include "viscache/correlation/pair_kernel.h"
#include "viscache/correlation/pair_rows.h"
#include "viscache/correlation/pair_tiles.h"

namespace viscache {

/// How the work is done; no option changes the result.
struct PairWork {
    int threads = 0;
    Isa isa = Isa::kPortable;
    bool skip_dead = true;  ///< skip bits that are 0 for all points of one side
};

/// Sums over the pairs of the tiles with the indices in `chosen`. Within a block the points are sorted by
/// normal, so that neighbours share dead directions.
PairTable pair_statistics(const PairRows& rows, const PairTiles& tiles, std::span<const uint64_t> chosen,
                          const BinEdges& distances, const BinEdges& angles, const PairWork& work,
                          Control& control);

/// n11 of every row of a with every row of b; out[a][b].
void intersections(const Word* a, size_t n_a, const Word* b, size_t n_b, size_t words, const PairWork& work,
                   int32_t* out, Control& control);

/// Σ n11 over all pairs of rows of a with rows of b, without storing them: the kernel alone.
uint64_t total_intersections(const Word* a, size_t n_a, const Word* b, size_t n_b, size_t words,
                             const PairWork& work, Control& control);

}  // namespace viscache

#include "viscache/correlation/pair_tiles.h"

#include <algorithm>
#include <stdexcept>
#include <string>

#include "viscache/correlation/pair_table.h"

namespace viscache {
namespace {
constexpr size_t kMaxBlocks = 8192;
}

PairTiles::PairTiles(std::span<const int32_t> group, size_t n_groups, size_t max_points) {
    if (max_points < 1) throw std::invalid_argument("tile must be >= 1, got 0");
    for (size_t i = 0; i < group.size(); ++i) {
        if (group[i] < 0 || size_t(group[i]) >= n_groups)
            throw std::invalid_argument("group must lie in [0, " + std::to_string(n_groups) + "), got " +
                                        std::to_string(group[i]));
        if (i && group[i] < group[i - 1])
            throw std::invalid_argument("points must be ordered by group, got group " +
                                        std::to_string(group[i]) + " after " + std::to_string(group[i - 1]));
    }
    for (size_t first = 0; first < group.size();) {
        size_t last = first;
        while (last < group.size() && group[last] == group[first]) ++last;
        // Blocks of nearly equal size, so that tiles are equal pieces of work.
        const size_t n = last - first, parts = (n + max_points - 1) / max_points;
        for (size_t k = 0; k < parts; ++k)
            blocks.push_back({first + n * k / parts, first + n * (k + 1) / parts, size_t(group[first])});
        first = last;
    }
    // Groups may be empty; the first block of such a group is that of the next one.
    std::vector<size_t> first_block(n_groups + 1, blocks.size());
    for (size_t b = blocks.size(); b-- > 0;) first_block[blocks[b].group] = b;
    for (size_t g = n_groups; g-- > 0;) first_block[g] = std::min(first_block[g], first_block[g + 1]);
    if (blocks.size() > kMaxBlocks)
        throw std::invalid_argument("tile must leave at most " + std::to_string(kMaxBlocks) +
                                    " blocks of points, got " + std::to_string(blocks.size()));
    for (size_t g = 0; g < n_groups; ++g)
        for (size_t h = g; h < n_groups; ++h)
            // Pairs of groups come first in the order: a range of tiles touches few rows of the table.
            for (size_t a = first_block[g]; a < first_block[g + 1]; ++a)
                // Inside a group only blocks a <= b: each pair of points once.
                for (size_t b = std::max(a, first_block[h]); b < first_block[h + 1]; ++b) {
                    const auto na = int64_t(blocks[a].size()), nb = int64_t(blocks[b].size());
                    tiles.push_back({a, b, group_pair(g, h, n_groups), a == b ? na * (na - 1) / 2 : na * nb});
                }
}

}  // namespace viscache

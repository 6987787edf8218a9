#include "viscache/vismap/dilation.h"

#include <array>
#include <vector>

#include "viscache/math/morton.h"
#include "viscache/math/octahedral.h"

namespace viscache {
namespace {

using Neighbours = std::array<uint16_t, 8>;
// Maps of less than 8 × 8 cells fill no word and are never dilated.
constexpr int kMinGrownLog2 = 3;

/// The eight neighbours of every cell.
std::vector<Neighbours> find_neighbours(int map_log2) {
    const int size = 1 << map_log2;
    std::vector<Neighbours> found(map_cells(map_log2));
    // In Morton order, x has the even bits of the code and y the odd ones.
    for (uint32_t z = 0; z < found.size(); ++z) {
        const int x = int(gather2(z)), y = int(gather2(z >> 1));
        size_t n = 0;
        for (int dy : {-1, 0, 1})
            for (int dx : {-1, 0, 1}) {
                if (!dx && !dy) continue;
                const MapCell c = folded({x + dx, y + dy}, size);
                found[z][n++] = uint16_t(morton2(uint32_t(c.x), uint32_t(c.y)));
            }
    }
    return found;
}

/// Tables of all sizes are made at the first use; afterwards threads only read them.
const std::vector<Neighbours>& neighbours(int map_log2) {
    static const auto tables = [] {
        std::array<std::vector<Neighbours>, kMaxMapLog2 + 1> all;
        for (int k = kMinGrownLog2; k <= kMaxMapLog2; ++k) all[size_t(k)] = find_neighbours(k);
        return all;
    }();
    return tables[size_t(map_log2)];
}

}  // namespace

void grow(int map_log2, const Word* bits, Word* grown) {
    const std::vector<Neighbours>& table = neighbours(map_log2);
    // A copy, so that bits that are set by dilation do not spread in turn.
    std::memcpy(grown, bits, map_words(map_log2) * sizeof(Word));
    for_each_bit({bits, map_words(map_log2)}, [&](size_t z) {
        for (uint16_t near : table[z]) set_bit(grown, near);
    });
}

void any_of_four(int map_log2, const Word* bits, Word* coarse) {
    std::memset(coarse, 0, map_words(map_log2 - 1) * sizeof(Word));
    for (size_t w = 0; w < map_words(map_log2); ++w) {
        // OR every four bits into the lowest of them, then pack sixteen results together
        // Each step closes half of the gaps between results:
        //
        //     ...a...b...c...d...e...f...g...h     one bit of four
        //     ......ab......cd......ef......gh     0303
        //     ............abcd............efgh     000f
        //     ........................abcdefgh     00ff
        Word any = bits[w] | bits[w] >> 1;
        any = (any | any >> 2) & 0x1111111111111111ull;
        any = (any | any >> 3) & 0x0303030303030303ull;
        any = (any | any >> 6) & 0x000f000f000f000full;
        any = (any | any >> 12) & 0x000000ff000000ffull;
        any = (any | any >> 24) & 0xffffull;
        coarse[w / 4] |= any << (16 * (w % 4));
    }
}

// `blocks` holds the map at ever coarser levels: any_of_four needs two buffers.
void dilate(int m, const Word* bits, int level, Word* dilated) {
    std::array<Word, map_words(kMaxMapLog2)> blocks, finer;
    std::memcpy(blocks.data(), bits, map_words(m) * sizeof(Word));
    for (int k = 1; k < level; ++k) {
        finer = blocks;
        any_of_four(m - k + 1, finer.data(), blocks.data());
    }
    grow(dilated_log2(m, level), blocks.data(), dilated);
}

}  // namespace viscache

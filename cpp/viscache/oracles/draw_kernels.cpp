#include "viscache/oracles/draw_kernels.h"

#include "viscache/math/isa_variants.h"

namespace viscache {
namespace {

typedef Word Row512 __attribute__((vector_size(64), may_alias));
#define VISCACHE_INLINE inline __attribute__((always_inline))

VISCACHE_INLINE Row512 load(const Word* p) { return *reinterpret_cast<const Row512*>(p); }
VISCACHE_INLINE void store(Word* p, Row512 v) { *reinterpret_cast<Row512*>(p) = v; }
VISCACHE_INLINE uint64_t ones(const Row512& v) {
    uint64_t n = 0;
    for (int i = 0; i < 8; ++i) n += uint64_t(__builtin_popcountll(v[i]));
    return n;
}
/// `mix64` of eight numbers.
VISCACHE_INLINE Row512 mixed(Row512 x) {
    x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9ull;
    x = (x ^ (x >> 27)) * 0x94D049BB133111EBull;
    return x ^ (x >> 31);
}

VISCACHE_INLINE void draw_body(const DrawRow& row, Word* drawn, Word* halved, uint64_t* counts) {
    constexpr uint64_t kStep = 0x9E3779B97F4A7C15ull;
    constexpr Row512 kLane{0, 1, 2, 3, 4, 5, 6, 7};
    const auto& octaves = *row.octaves;
    for (size_t w = 0; w < row.words; w += 8) {
        // The queries of each class; classes of equal octaves count the same bounds
        const Row512 asked = load(row.wanted + w);
        const Row512 pairs[3][2] = {{~load(row.differs + w), load(row.differs + w)},
                                    {~load(row.visible + w), load(row.visible + w)},
                                    {~load(row.doubts + w), load(row.doubts + w)}};
        Row512 with_octaves[kMostOctaves + 1] = {};
        for (size_t c = 0; c < kAnswerClasses; ++c) {
            const Row512 mine = asked & pairs[0][c & 1] & pairs[1][c >> 1 & 1] & pairs[2][c >> 2 & 1];
            counts[c] += ones(mine);
            with_octaves[octaves[c]] |= mine;
        }
        // Bound after bound, a mask clears half of the queries below it
        Row512 left = asked;
        for (size_t h = 0; h < kMostHalvings; ++h) {
            Row512 below{};
            for (size_t o = 0; o <= kMostOctaves; ++o)
                if (const Word* bound = row.below_bound[kMostOctaves - o + h])
                    below |= with_octaves[o] & load(bound + w);
            store(halved + h * row.words + w, below);
            const Row512 number = (kLane + w) * kMostHalvings + h;
            const Word flip = row.turn >> h & 1 ? ~Word{0} : Word{0};
            left &= ~below | (mixed(row.key + number * kStep) ^ flip);
        }
        store(drawn + w, left);
    }
}

VISCACHE_INLINE void differs_body(const Word* wanted, const Word* visible, Word* differs, size_t words) {
    for (size_t w = 0; w < words; ++w) {
        const auto before = [&](const Word* row) __attribute__((always_inline)) {
            return row[w] << 1 | (w ? row[w - 1] >> 63 : 0);
        };
        const auto after = [&](const Word* row) __attribute__((always_inline)) {
            return row[w] >> 1 | (w + 1 < words ? row[w + 1] << 63 : 0);
        };
        differs[w] = (before(wanted) & (before(visible) ^ visible[w])) |
                     (after(wanted) & (after(visible) ^ visible[w]));
    }
}

VISCACHE_INLINE uint64_t count_body(const Word* a, size_t words) {
    uint64_t n = 0;
    for (size_t w = 0; w < words; w += 8) n += ones(load(a + w));
    return n;
}

#undef VISCACHE_INLINE

constexpr DrawKernels kernels_of(Isa isa) {
    return {variant_of<draw_body>(isa), variant_of<differs_body>(isa), variant_of<count_body>(isa)};
}

}  // namespace

const DrawKernels& draw_kernels(Isa isa) { return table_of<kernels_of>(isa); }

}  // namespace viscache

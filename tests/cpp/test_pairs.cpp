// correlation: pair statistics of a few points on several threads and in every instruction set.
#include <random>

#include "check.h"
#include "viscache/correlation/neighbourhood.h"

namespace viscache::test::pairs_tests {
namespace {

constexpr size_t kPoints = 150, kWords = 5;

/// Rows of 300 bits with points and normals in two groups.
struct Example {
    Example() {
        std::mt19937 random(1);
        std::uniform_real_distribution<float> uniform(-1, 1);
        for (size_t i = 0; i < kPoints; ++i) {
            position.push_back({uniform(random), uniform(random), 0});
            normal.push_back(normalize({uniform(random), uniform(random), 1}));
            group.push_back(i < 70 ? 0 : 1);
            for (size_t w = 0; w < kWords; ++w) {
                const Word word = Word(random()) << 32 | random();
                bits.push_back(i % 10 == 0 ? 0 : w == 4 ? word & ((Word{1} << 44) - 1) : word);
            }
        }
        rows = {.bits = bits.data(),
                .words = kWords,
                .n_directions = 300,
                .position = position,
                .normal = normal,
                .group = group,
                .n_groups = 2};
    }
    std::vector<Word> bits;
    std::vector<Vec3> position, normal;
    std::vector<int32_t> group;
    PairRows rows;
};

const double kDistances[] = {0, 0.2, 0.5, 1, 3}, kAngles[] = {0, 10, 45, 180};

PairTable statistics(const Example& e, PairWork work, size_t tile) {
    const PairTiles tiles(e.group, 2, tile);
    std::vector<uint64_t> all(tiles.tiles.size());
    for (size_t t = 0; t < all.size(); ++t) all[t] = t;
    Control control;
    return pair_statistics(e.rows, tiles, all, BinEdges::distances(kDistances), BinEdges::angles(kAngles),
                           work, control);
}

bool same(const PairTable& a, const PairTable& b) {
    return a.n == b.n && a.n_undefined == b.n_undefined && a.sum_q == b.sum_q &&
           a.sum_q2_high == b.sum_q2_high && a.sum_q2_low == b.sum_q2_low;
}

void all_ways_give_the_same_sums() {
    const Example e;
    const PairTable first = statistics(e, {.threads = 1}, 2048);
    int64_t pairs = 0;
    for (size_t c = 0; c < first.n.size(); ++c) pairs += first.n[c] + first.n_undefined[c];
    check_equal(pairs, int64_t(kPoints * (kPoints - 1) / 2), "pairs in the table");
    for (Isa isa : {Isa::kPortable, Isa::kAvx2, Isa::kAvx512}) {
        if (isa > best_isa()) continue;
        const std::string name(isa_name(isa));
        for (size_t tile : {7, 64})
            check(same(statistics(e, {.threads = 4, .isa = isa}, tile), first),
                  "sums of tiles on threads, " + name);
        Control control;
        check(same(near_pairs(e.rows, BinEdges::distances(kDistances), BinEdges::angles(kAngles), 3,
                              {.threads = 4, .isa = isa}, control),
                   first),
              "sums of near pairs, " + name);
    }
}

void a_cancelled_call_ends() {
    const Example e;
    Control control;
    control.cancel = true;
    check_throws<Cancelled>([&] { spatial_map(e.rows, 1, 90, {.threads = 2}, control); }, "a cancelled call");
}

void keys_find_the_bin_of_binary_search() {
    std::vector<double> edges;
    for (int i = 0; i < 400; ++i) edges.push_back(0.01 * i);
    const BinEdges bins = BinEdges::distances(edges);
    std::mt19937 random(2);
    std::uniform_real_distribution<float> uniform(0, 20);
    for (int i = 0; i < 10000; ++i) {
        const float d2 = uniform(random);
        size_t below = 0;
        while (below < edges.size() && edges[below] * edges[below] <= double(d2)) ++below;
        check_equal(size_t(bins.table().code(distance_key(d2))), below, "edges at or below");
    }
}

const Suite suite{
    {"pairs: all ways give the same sums", all_ways_give_the_same_sums},
    {"pairs: a cancelled call ends", a_cancelled_call_ends},
    {"pairs: keys find the bin of a binary search", keys_find_the_bin_of_binary_search},
};

}  // namespace
}  // namespace viscache::test::pairs_tests

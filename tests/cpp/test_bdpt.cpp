// Weights of bidirectional paths, and the table that racing threads share.
#include <cstring>
#include <random>
#include <thread>

#include "check.h"
#include "viscache/aqvc/aqvc_source.h"
#include "viscache/casters/bsp_caster.h"
#include "viscache/render/bdpt.h"
#include "viscache/render/path_weight.h"

namespace viscache::test::bdpt_tests {
namespace {

/// Every word that a thread reads was written by some thread for that slot.
void racing_words_are_never_mixed() {
    RacingBitTable table(64, 31, HashScheme::kScheme2);
    const auto work = [&](uint32_t who) {
        TableCounts counts;
        for (uint32_t i = 0; i < 20000; ++i) {
            const uint32_t n = (i * 7 + who * 13) % 512;
            // The bit follows from the digest, so a mixed word is detected
            const KeyHash h{n, n * 2654435761u >> 1 | 1};
            const auto found = table.get_hashed(h);
            if (found) check_equal(*found, bool(n & 1), "value of a word");
            table.put_hashed(h, n & 1, counts);
        }
    };
    std::vector<std::thread> threads;
    for (uint32_t who = 0; who < 4; ++who) threads.emplace_back(work, who);
    for (std::thread& t : threads) t.join();
    check(table.occupied() >= 64 && table.occupied() <= 64 * 4, "slots in use, up to races");
}

/// A path x₀ (camera) … x_k (light) with the densities of both sides at every vertex.
struct WholePath {
    std::vector<double> by_eye, by_light;
    std::vector<bool> connects;
    StrategyRules rules;

    PathVertex vertex(size_t i, bool from_eye) const {
        PathVertex v;
        v.forward = from_eye ? by_eye[i] : by_light[i];
        v.reverse = from_eye ? by_light[i] : by_eye[i];
        v.connects = connects[i];
        return v;
    }
    size_t size() const { return by_eye.size(); }
    /// True if s vertices from the light and the others from the eye can form the path.
    bool possible(size_t s) const {
        const size_t t = size() - s;
        if (s == 0) return rules.hittable;
        return t >= 1 && connects[t - 1] && connects[t] && (t > 1 || (rules.to_camera && s > 1));
    }
    double weight(size_t s) const {
        const size_t n = size(), t = n - s;
        std::vector<PathVertex> eye, light;
        for (size_t i = 0; i < t; ++i) eye.push_back(vertex(i, true));
        for (size_t i = n; i-- > t;) light.push_back(vertex(i, false));
        JoinDensities join;
        join.eye_last = by_light[t - 1];
        if (t > 1) join.eye_before = by_light[t - 2];
        if (s > 0) join.light_last = by_eye[t];
        if (s > 1) join.light_before = by_eye[t + 1];
        return path_weight(eye, light, join, rules);
    }
    /// The balance heuristic as printed: the density of one strategy divided by the sum of all.
    double expected(size_t s) const {
        double own = 0, sum = 0;
        for (size_t k = 0; k < size(); ++k) {
            double density = 1;
            for (size_t i = 0; i < size(); ++i) density *= i < size() - k ? by_eye[i] : by_light[i];
            if (possible(k)) sum += density;
            if (k == s) own = density;
        }
        return own / sum;
    }
};

void weights_are_the_balance_heuristic() {
    std::mt19937 random(5);
    std::uniform_real_distribution<double> uniform(0.1, 3);
    for (int round = 0; round < 300; ++round) {
        WholePath path;
        const size_t n = 2 + random() % 7;
        for (size_t i = 0; i < n; ++i) {
            path.by_eye.push_back(i ? uniform(random) : 1);
            path.by_light.push_back(uniform(random));
            path.connects.push_back(i == 0 || i == n - 1 || random() % 4 > 0);
        }
        path.rules = {random() % 2 == 0, random() % 2 == 0};
        double sum = 0;
        bool any = false;
        for (size_t s = 0; s < n; ++s) {
            if (!path.possible(s)) continue;
            any = true;
            sum += path.weight(s);
            check_near(path.weight(s), path.expected(s), 1e-9, "weight of a strategy");
        }
        if (any) check_near(sum, 1, 1e-9, "weights of all strategies");
        if (!path.rules.hittable)
            check_near(path.weight(0), any ? 0 : 1, 0, "weight of a light that is not hit on purpose");
    }
}

const Suite suite{
    {"bdpt: weights are the balance heuristic", weights_are_the_balance_heuristic},
    {"bdpt: racing words are never mixed", racing_words_are_never_mixed},
};

}  // namespace
}  // namespace viscache::test::bdpt_tests

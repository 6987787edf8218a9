// Bidirectional path tracing on several threads with one table. With batches the result does not depend on
// the number of threads; with racing threads there are no data races.
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

void add_quad(SceneDescription& d, Vec3 corner, Vec3 a, Vec3 b, int material, Rgb emission = {}) {
    Mesh mesh;
    mesh.vertices = {corner, corner + a, corner + a + b, corner + b};
    mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
    mesh.material = material;
    mesh.emission = emission;
    d.meshes.push_back(std::move(mesh));
}

/// A floor, a wall, a glass board, a lamp, a point light and a sky.
std::shared_ptr<const Scene> scene() {
    SceneDescription d;
    d.materials.push_back({.base_color = {0.6f, 0.5f, 0.4f}});
    d.materials.push_back({.kind = MaterialKind::kDielectric});
    add_quad(d, {-2, 0, -2}, {0, 0, 4}, {4, 0, 0}, 0);
    add_quad(d, {-2, 0, -2}, {4, 0, 0}, {0, 3, 0}, 0);
    add_quad(d, {-1, 0.3f, 0}, {1, 0, 0.2f}, {0, 1, 0}, 1);
    add_quad(d, {-0.5f, 2, -0.5f}, {1, 0, 0}, {0, 0, 1}, 0, {5, 5, 5});
    d.point_lights.push_back({{1.5f, 1, 1}, {2, 2, 2}});
    d.environment = Environment{.scale = {0.1f, 0.2f, 0.3f}};
    return Scene::freeze(std::move(d));
}

struct Setup {
    std::shared_ptr<const Scene> world = scene();
    Control control;
    BspCaster caster{world, {}, 1, control};
    Camera camera = look_at({0, 1, 4}, {0, 0.7f, 0}, {0, 1, 0}, 0.9f);

    FrameResult render(int threads, const AqvcParameters& p) {
        FrameTableSource source(*world, caster, p, 1);
        const FrameSettings frame{.width = 40, .height = 30, .spp = 2, .threads = threads};
        const BdptSettings settings{.max_depth = 4, .camera_connections = CameraConnections::kKeyed};
        return render_bdpt(*world, caster, camera, settings, frame, source, control);
    }
};

AqvcParameters parameters(Storage storage) {
    AqvcParameters p;
    p.storage = storage;
    p.refinement.fill(Refinement::kOff);
    p.table_bytes = 1 << 14;
    return p;
}

void threads_do_not_matter() {
    Setup setup;
    for (const Storage storage : {Storage::kTable, Storage::kExact}) {
        const AqvcParameters p = parameters(storage);
        const FrameResult a = setup.render(1, p), b = setup.render(4, p);
        check(std::memcmp(a.color.data(), b.color.data(), a.color.size() * sizeof(Rgb)) == 0, "same pixels");
        check_equal(a.counters.rays(), b.counters.rays(), "rays");
        check_equal(a.counters.duplicates, b.counters.duplicates, "rays traced twice");
        check(a.counters.rays() < a.counters.queries(), "the cache answers");
    }
}

void races_are_counted() {
    Setup setup;
    const AqvcParameters p = parameters(Storage::kShared);
    const Counters c = setup.render(4, p).counters;
    check(c.rays() < c.queries(), "the cache answers");
    check_equal(c.table_writes + c.bypassed, c.rays(), "every ray is written or bypassed");
    check_equal(c.table_slots, largest_prime(p.table_bytes / 4), "slots");
}

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
    {"bdpt: a table written between rounds gives the same values on any threads", threads_do_not_matter},
    {"bdpt: racing threads count every ray", races_are_counted},
    {"bdpt: racing words are never mixed", racing_words_are_never_mixed},
};

}  // namespace
}  // namespace viscache::test::bdpt_tests

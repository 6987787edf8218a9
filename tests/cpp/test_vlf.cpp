// The visibility field: traversals stay inside their lists for any ray, and many threads share a store.
#include <cmath>
#include <random>

#include "check.h"
#include "viscache/vlf/dynamic.h"

namespace viscache::test::vlf_tests {
namespace {

std::mt19937 random(7);

float uniform(float lo, float hi) { return std::uniform_real_distribution<float>(lo, hi)(random); }
Vec3 in_cube() { return {uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)}; }

FlatTriangle triangle(float size) {
    const Vec3 p = in_cube();
    return {p, p + in_cube() * size, p + in_cube() * size};
}

std::shared_ptr<const Scene> soup(uint32_t n) {
    SceneDescription d;
    d.materials.emplace_back();
    Mesh mesh;
    for (uint32_t i = 0; i < n; ++i) {
        const FlatTriangle t = triangle(0.3f);
        mesh.vertices.insert(mesh.vertices.end(), {t.a, t.b, t.c});
        mesh.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    }
    d.meshes.push_back(std::move(mesh));
    return Scene::freeze(std::move(d));
}

FieldSettings small(uint32_t l, int n, int depth) {
    FieldSettings s;
    s.n_directions = l;
    s.n_tiles = n;
    s.bsp_depth = depth;
    s.leaf_target = 1;
    return s;
}

/// Rays with small depth components, along borders, through corners, from far away and of any length.
Ray odd_ray() {
    Vec3 o = in_cube() * 1.5f, d = in_cube();
    const auto tiny = [] { return std::ldexp(uniform(-1, 1), -int(random() % 140)); };
    if (random() % 2) d.z = tiny();
    if (random() % 4 == 0) d.x = tiny();
    if (random() % 4 == 0) o = {std::round(o.x * 8) / 8, std::round(o.y * 8) / 8, std::round(o.z * 8) / 8};
    if (random() % 8 == 0) d = {std::round(d.x * 2), std::round(d.y * 2), std::round(d.z * 2)};
    if (random() % 16 == 0) o = o * std::ldexp(1.f, int(random() % 50));
    if (random() % 16 == 0) d = d * std::ldexp(1.f, int(random() % 100) - 50);
    return {o, random() % 4 ? 0.f : uniform(0, 2), d, random() % 4 ? kInfinity : uniform(0, 2)};
}

void odd_rays_stay_in_their_lists() {
    const auto scene = soup(200);
    Control control;
    for (const auto& [l, n, depth] : {std::array{1, 40, 6}, {3, 64, 12}, {33, 1, 5}, {129, 17, 0}})
        for (const DepthSplit split : {DepthSplit::kUniform, DepthSplit::kObject})
            for (const LeafWalk walk : {LeafWalk::kLinear, LeafWalk::kStack}) {
                FieldSettings s = small(uint32_t(l), n, depth);
                s.split = split;
                s.walk = walk;
                const VisibilityField field(scene, s, 2, control);
                for (int i = 0; i < 4000; ++i) {
                    const Ray ray = odd_ray();
                    Hit hit;
                    uint8_t any = 0;
                    field.intersect({&ray, 1}, {&hit, 1}, Coherence::kIncoherent);
                    field.occluded({&ray, 1}, {&any, 1});
                    check_equal(bool(any), hit.valid(), "any hit of a ray with a nearest one");
                    check(!hit.valid() || (hit.t >= ray.t_min && hit.t <= ray.t_max), "hits lie on the ray");
                }
            }
}

void many_threads_use_a_small_store() {
    FieldSettings s = small(33, 16, 3);
    s.lazy = true;
    s.max_bytes = 60000;
    Control control;
    const VisibilityField field(soup(100), s, 1, control);
    parallel_for(64, 4, [&](size_t, int) {
        std::vector<Ray> rays(64);
        std::vector<uint8_t> occluded(64);
        for (size_t i = 0; i < rays.size(); ++i)
            rays[i] = {{float(i) / 32 - 1, 0.1f, 0}, 0, directions_of(33).axes()[(i * 7) % 33], kInfinity};
        field.occluded(rays, occluded);
    });
    const FieldStats stats = field.stats();
    check(stats.evicted > 0, "a small store evicts subfields");
    check_equal(stats.built - stats.evicted, stats.subfields, "built subfields without the evicted ones");
}

void objects_come_go_and_move() {
    for (const UpdateMode mode : {UpdateMode::kOverlay, UpdateMode::kInPlace}) {
        FieldSettings s = small(9, 12, 3);
        s.head_room = 2;
        Control control;
        DynamicField field(soup(50), s, mode, 1, control);
        std::vector<uint32_t> objects;
        for (int step = 0; step < 200; ++step) {
            const uint32_t what = random() % 4;
            if (what == 0 || objects.empty()) {
                std::vector<FlatTriangle> triangles;
                for (uint32_t i = 0; i < 1 + random() % 6; ++i) triangles.push_back(triangle(0.5f));
                objects.push_back(field.insert(std::move(triangles), 2));
            } else if (what == 1) {
                field.remove(objects.back(), 2);
                objects.pop_back();
            } else {
                Affine place;
                for (int i = 0; i < 3; ++i) place.m[size_t(i)][3] = uniform(-0.4f, 0.4f);
                field.transform(objects[random() % objects.size()], place, 2);
            }
            const Ray ray = odd_ray();
            const DynamicHit hit = field.nearest(ray);
            check_equal(field.any(ray), hit.object != DynamicHit::kNothing, "any hit beside the nearest");
        }
        for (uint32_t d = 0; d < 9; ++d)
            check(field.listed(d) == field.listed_anew(d), "lists are those of a field built anew");
    }
}

const Suite suite{
    {"odd rays stay in their lists", odd_rays_stay_in_their_lists},
    {"many threads use a small store", many_threads_use_a_small_store},
    {"objects come, go and move", objects_come_go_and_move},
};

}  // namespace
}  // namespace viscache::test::vlf_tests

// The single-ray BSP: builds on several threads, rays through special positions, and builds that exceed their
// limits.
#include <random>

#include "check.h"
#include "viscache/casters/bsp_caster.h"

namespace viscache::test::bsp_tests {
namespace {

std::mt19937 random(11);

float uniform(float lo, float hi) { return std::uniform_real_distribution<float>(lo, hi)(random); }
Vec3 in_cube() { return {uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)}; }

std::vector<FlatTriangle> soup(int n, float size) {
    std::vector<FlatTriangle> triangles;
    for (int i = 0; i < n; ++i) {
        const Vec3 p = in_cube();
        triangles.push_back({p, p + in_cube() * size, p + in_cube() * size});
    }
    return triangles;
}

/// A slab of adjacent triangles.
std::vector<FlatTriangle> slab(int n) {
    const auto near = [](Vec3 p) { return p + in_cube() * Vec3{0.5f, 0.5f, 0.02f}; };
    std::vector<FlatTriangle> triangles;
    for (int i = 0; i < n; ++i) triangles.push_back({near({-1, -1, 0}), near({1, -1, 0}), near({0, 1, 0})});
    return triangles;
}

std::shared_ptr<const Scene> scene_of(const std::vector<FlatTriangle>& triangles) {
    SceneDescription d;
    d.materials.emplace_back();
    Mesh mesh;
    for (const FlatTriangle& t : triangles) {
        const auto first = uint32_t(mesh.vertices.size());
        mesh.vertices.insert(mesh.vertices.end(), {t.a, t.b, t.c});
        mesh.triangles.push_back({first, first + 1, first + 2});
    }
    d.meshes.push_back(std::move(mesh));
    return Scene::freeze(std::move(d));
}

bool same(const BspTree& a, const BspTree& b) {
    const auto equal = [](const BspNode& x, const BspNode& y) {
        return x.value == y.value && x.word == y.word;
    };
    return a.ids == b.ids &&
           std::equal(a.nodes.begin(), a.nodes.end(), b.nodes.begin(), b.nodes.end(), equal);
}

void trees_are_the_same_on_any_threads() {
    const auto triangles = soup(300, 0.4f);
    for (const auto& [depth, leaf] : {std::array{1, 8}, {6, 1}, {9, 4}, {0, 8}}) {
        BspSettings s;
        s.max_depth = depth;
        s.leaf_size = leaf;
        const BspTree one = build_bsp(triangles, s, 1, Control{});
        check(same(one, build_bsp(triangles, s, 4, Control{})), "the tree of four threads");
        check(one.depth <= s.depth(triangles.size()), "no leaf lies deeper than allowed");
    }
}

void hits_are_those_of_one_large_leaf() {
    const auto scene = scene_of(soup(200, 0.4f));
    for (const TriangleKernel kernel : {TriangleKernel::kWatertight, TriangleKernel::kWald}) {
        Control control;
        BspSettings list, tree;
        list.leaf_size = 1024;
        tree.max_depth = 9;
        tree.leaf_size = 2;
        list.kernel = tree.kernel = kernel;
        const BspCaster all(scene, list, 1, control), some(scene, tree, 2, control);
        for (int i = 0; i < 4000; ++i) {
            Vec3 o = in_cube() * 2, d = in_cube();
            if (i % 3 == 0) d.x = 0;
            if (i % 5 == 0) d.y = std::ldexp(uniform(-1, 1), -int(random() % 140));
            if (i % 7 == 0) o = {std::round(o.x * 4) / 4, std::round(o.y * 4) / 4, std::round(o.z * 4) / 4};
            const Ray ray{o, 0, d, i % 2 ? kInfinity : uniform(0, 3)};
            Hit a, b;
            uint8_t any = 0;
            all.intersect({&ray, 1}, {&a, 1}, Coherence::kIncoherent);
            some.intersect({&ray, 1}, {&b, 1}, Coherence::kIncoherent);
            some.occluded({&ray, 1}, {&any, 1});
            check(a.triangle == b.triangle && a.t == b.t, "the hit of all triangles tried");
            check_equal(bool(any), b.valid(), "any hit of a ray with a nearest one");
        }
    }
}

void a_tree_that_exceeds_its_limits_is_refused() {
    BspSettings s;
    s.max_depth = kMostBspDepth;
    for (const int threads : {1, 3}) {
        bool refused = false;
        try {
            build_bsp(slab(100), s, threads, Control{});
        } catch (const OverBudget&) {
            refused = true;
        }
        check(refused, "a hundred triangles side by side, forty halvings deep");
    }
    s.max_depth = 0;
    check_equal(build_bsp(slab(100), s, 2, Control{}).max_depth, 12,
                "the default depth follows from the number of triangles");
}

void a_cancelled_build_ends() {
    Control control;
    control.cancel = true;
    bool cancelled = false;
    try {
        build_bsp(soup(300, 0.4f), {}, 2, control);
    } catch (const Cancelled&) {
        cancelled = true;
    }
    check(cancelled, "a build that was cancelled");
}

const Suite suite{
    {"trees are the same on any threads", trees_are_the_same_on_any_threads},
    {"hits are those of one large leaf", hits_are_those_of_one_large_leaf},
    {"a tree that exceeds its limits is refused", a_tree_that_exceeds_its_limits_is_refused},
    {"a cancelled build ends", a_cancelled_build_ends},
};

}  // namespace
}  // namespace viscache::test::bsp_tests

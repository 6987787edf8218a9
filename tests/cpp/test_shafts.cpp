// Shafts: the order of packets, and the trees.
#include <cstddef>
#include <cstring>
#include <functional>
#include <random>
#include <set>

#include "check.h"
#include "viscache/shafts/shaft_scene.h"
#include "viscache/visibility/point_order.h"
#include "viscache/visibility/segment_packets.h"
#include "viscache/visibility/shadow_ray.h"

namespace viscache::test::shafts_tests {
namespace {

std::mt19937 random(5);

float uniform(float lo, float hi) { return std::uniform_real_distribution<float>(lo, hi)(random); }
Vec3 in_cube() { return {uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)}; }

std::shared_ptr<const Scene> soup(int n, float size) {
    SceneDescription d;
    d.materials.emplace_back();
    Mesh mesh;
    for (int i = 0; i < n; ++i) {
        const Vec3 p = in_cube();
        const auto first = uint32_t(mesh.vertices.size());
        mesh.vertices.insert(mesh.vertices.end(), {p, p + in_cube() * size, p + in_cube() * size});
        mesh.triangles.push_back({first, first + 1, first + 2});
    }
    d.meshes.push_back(std::move(mesh));
    return Scene::freeze(std::move(d));
}

void packets_are_compact() {
    std::vector<Vec3> points;
    for (int i = 0; i < 1000; ++i) points.push_back(in_cube());
    points[7].x = std::nanf("");
    const std::vector<uint32_t> order = packet_order(points);
    check_equal(std::set<uint32_t>(order.begin(), order.end()).size(), points.size(), "points in the order");
    check(order == packet_order(points), "the order is the same again");
    // The left half, 512 points, lies on one side of a plane
    const auto x = [&](size_t i) { return points[order[i]].x; };
    const auto y = [&](size_t i) { return points[order[i]].y; };
    const auto z = [&](size_t i) { return points[order[i]].z; };
    const auto splits = [&](auto at) {
        float left = -kInfinity, right = kInfinity;
        for (size_t i = 0; i < 512; ++i) left = std::max(left, at(i));
        for (size_t i = 512; i < points.size(); ++i) right = std::min(right, at(i));
        return left <= right;
    };
    check(splits(x) || splits(y) || splits(z), "a plane splits the points");
    BitMatrix bits(1000, 70), there, back(1000, 70);
    for (size_t i = 0; i < 1000; ++i)
        for (size_t k = 0; k < 70; ++k)
            if (random() % 3 == 0) bits.set(i, k);
    gather_rows(bits, order, there);
    scatter_rows(there, order, back);
    bool same = true, moved = false;
    for (size_t i = 0; i < 1000; ++i) {
        same = same && std::memcmp(bits.row(i), back.row(i), 2 * sizeof(Word)) == 0;
        moved = moved || std::memcmp(bits.row(i), there.row(i), 2 * sizeof(Word)) != 0;
    }
    check(same, "rows come back to their place");
    check(moved, "rows move");
}

using Visit = std::function<void(const ShaftBlock&, int, bool)>;

/// Visits the triangles below a node, and says whether all boxes around a triangle hold it.
void for_each_triangle(const ShaftTree& tree, int32_t index, const Visit& visit) {
    const ShaftNode& node = tree.nodes[size_t(index)];
    for (int lane = 0; lane < 16; ++lane) {
        if (!(node.used >> lane & 1)) continue;
        const Visit in_box = [&](const ShaftBlock& b, int i, bool in) {
            for (int c = 0; c < 9; ++c)
                in = in && b.corner[c][i] >= node.lo[c % 3][lane] && b.corner[c][i] <= node.hi[c % 3][lane];
            visit(b, i, in);
        };
        if (!(node.leaves >> lane & 1)) {
            for_each_triangle(tree, node.child[lane], in_box);
            continue;
        }
        const ShaftBlock& b = tree.blocks[size_t(~node.child[lane])];
        for (int i = 0; i < 16; ++i)
            if (b.used >> i & 1) in_box(b, i, true);
    }
}

void trees_hold_every_triangle_in_its_boxes() {
    for (const int n : {1, 16, 17, 5000}) {
        const auto scene = soup(n, 0.3f);
        const ShaftScene shafts(scene);
        size_t found = 0, outside = 0;
        std::set<std::array<float, 9>> distinct;
        for_each_triangle(shafts.tree(1, Control{}), 0, [&](const ShaftBlock& b, int i, bool in) {
            ++found;
            outside += !in;
            std::array<float, 9> corners;
            for (size_t c = 0; c < 9; ++c) corners[c] = b.corner[c][i];
            distinct.insert(corners);
        });
        check_equal(found, size_t(n), "triangles of the tree");
        check_equal(distinct.size(), size_t(n), "distinct triangles of the tree");
        check_equal(outside, size_t{0}, "triangles outside of a box");
        check(shafts.tree(1, Control{}).bytes() <= most_shaft_bytes(uint64_t(n)),
              "the bound of the memory holds");
    }
}

template <class Record>
bool same_bytes(const std::vector<Record>& a, const std::vector<Record>& b, size_t used) {
    bool same = a.size() == b.size();
    for (size_t i = 0; same && i < a.size(); ++i) same = std::memcmp(&a[i], &b[i], used) == 0;
    return same;
}

/// More triangles than one thread splits alone, half of them in one place.
void trees_are_the_same_for_any_number_of_threads() {
    random.seed(6);
    std::vector<ShaftTriangle> triangles;
    for (int i = 0; i < 60000; ++i) {
        const Vec3 p = i % 2 ? in_cube() : Vec3{0.1f, 0.2f, 0.3f};
        triangles.push_back({{p, p + in_cube() * 0.02f, p + in_cube() * 0.02f}, i % 5 != 0});
    }
    const ShaftTree alone = build_shaft_tree(triangles, 1, Control{});
    size_t found = 0, outside = 0;
    for_each_triangle(alone, 0, [&](const ShaftBlock&, int, bool in) {
        ++found;
        outside += !in;
    });
    check_equal(found, triangles.size(), "triangles of the tree");
    check_equal(outside, size_t{0}, "triangles outside of a box");
    for (const int threads : {2, 3, 8}) {
        const ShaftTree tree = build_shaft_tree(triangles, threads, Control{});
        check(same_bytes(tree.nodes, alone.nodes, offsetof(ShaftNode, leaves) + sizeof(uint32_t)), "nodes");
        check(same_bytes(tree.blocks, alone.blocks, offsetof(ShaftBlock, holed) + sizeof(uint32_t)),
              "blocks");
        check(tree.bounds.lo == alone.bounds.lo && tree.bounds.hi == alone.bounds.hi, "bounds");
    }
    Control cancelled;
    cancelled.cancel = true;
    bool stopped = false;
    try {
        build_shaft_tree(triangles, 2, cancelled);
    } catch (const Cancelled&) {
        stopped = true;
    }
    check(stopped, "a build can be cancelled");
}

/// Segments in lanes are the floats of single ones, also where two points are one.
void segments_in_lanes_are_those_of_query() {
    random.seed(8);
    for (int turn = 0; turn < 100; ++turn) {
        Vec3 from[16], to[16];
        RayPacket16 packet;
        for (int i = 0; i < 16; ++i) {
            from[i] = i == 3 ? Vec3{} : in_cube() * std::pow(10.f, uniform(-6, 6));
            to[i] = i == 3 || i == 5 ? from[i] : i == 7 ? from[i] * 1.000001f : in_cube();
            packet.set(i, {from[i], 0, to[i], 0});
        }
        segments16(packet);
        for (int i = 0; i < 16; ++i) {
            const Ray ray = segment_between(from[i], to[i]);
            check(packet.t_min[i] == ray.t_min && packet.t_max[i] == ray.t_max, "ends of a segment");
            check(Vec3{packet.dx[i], packet.dy[i], packet.dz[i]} == ray.d, "direction of a segment");
        }
    }
}

const Suite suite{
    {"packets are compact, and rows return to their place", packets_are_compact},
    {"shaft trees hold every triangle in its boxes", trees_hold_every_triangle_in_its_boxes},
    {"shaft trees are the same for any number of threads", trees_are_the_same_for_any_number_of_threads},
    {"segments in lanes are those of single ones", segments_in_lanes_are_those_of_query},
};

}  // namespace
}  // namespace viscache::test::shafts_tests

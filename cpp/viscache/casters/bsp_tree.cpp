#include "viscache/casters/bsp_tree.h"

#include <numeric>
#include <optional>
#include <utility>

namespace viscache {

namespace {

constexpr size_t kSubtrees = 64;  // built in parallel

/// A subtree that is still to be built.
struct Task {
    std::vector<uint32_t> ids;
    Bounds cell;
    int depth;
    int barren;  ///< number of consecutive halvings that separated no triangles
};

struct Halves {
    int axis;
    float plane;
    Task low, high;
};

class Builder {
public:
    Builder(std::span<const FlatTriangle> triangles, const BspSettings& settings, int max_depth, float pad,
            const Control& control)
        : triangles_(triangles), settings_(settings), max_depth_(max_depth), pad_(pad), control_(control) {}

    /// The two halves of a cell; empty if the cell becomes a leaf.
    std::optional<Halves> halve(const Task& task) const;
    /// Builds the subtree of a task; its root is nodes[root].
    void subtree(Task task, size_t root, BspTree& tree);
    void leaf(const Task& task, size_t at, BspTree& tree);

private:
    std::vector<uint32_t> inside(std::span<const uint32_t> ids, const Bounds& cell) const;
    void spend(uint64_t bytes);
    void work(uint64_t tests) const;

    std::span<const FlatTriangle> triangles_;
    const BspSettings& settings_;
    int max_depth_;
    float pad_;
    const Control& control_;
    std::atomic<uint64_t> bytes_{0};
    mutable std::atomic<uint64_t> tests_{0};
};

int longest_axis(Vec3 size) {
    const int axis = size.y > size.x ? 1 : 0;
    return size.z > size[axis] ? 2 : axis;
}

void set(Vec3& v, int axis, float value) { (axis == 0 ? v.x : axis == 1 ? v.y : v.z) = value; }

std::vector<uint32_t> Builder::inside(std::span<const uint32_t> ids, const Bounds& cell) const {
    const Vec3 half = (cell.hi - cell.lo) * 0.5f + Vec3{pad_, pad_, pad_};
    const Vec3 center = cell.lo * 0.5f + cell.hi * 0.5f;
    std::vector<uint32_t> found;
    for (uint32_t id : ids)
        if (triangle_meets_box(triangles_[id], center, half)) found.push_back(id);
    return found;
}

std::optional<Halves> Builder::halve(const Task& task) const {
    control_.check();
    // After three halvings, one per axis, without separation, further ones will not separate the triangles
    // either
    if (task.depth >= max_depth_ || task.ids.size() <= size_t(settings_.leaf_size) || task.barren >= 3)
        return std::nullopt;
    const int axis = longest_axis(task.cell.hi - task.cell.lo);
    const float lo = task.cell.lo[axis], hi = task.cell.hi[axis], plane = lo * 0.5f + hi * 0.5f;
    if (!(plane > lo && plane < hi)) return std::nullopt;
    work(2 * task.ids.size());
    Halves halves{axis, plane, {{}, task.cell, task.depth + 1, 0}, {{}, task.cell, task.depth + 1, 0}};
    set(halves.low.cell.hi, axis, plane);
    set(halves.high.cell.lo, axis, plane);
    for (Task* half : {&halves.low, &halves.high}) half->ids = inside(task.ids, half->cell);
    const size_t all = task.ids.size();
    if (halves.low.ids.size() == all && halves.high.ids.size() == all)
        halves.low.barren = halves.high.barren = task.barren + 1;
    return halves;
}

/// Bounds the work. Triangles that are close together are listed in all cells of their common surface. The
/// number of these cells doubles in two of three halvings, so a deep limit would take hours long before it
/// takes much memory.
void Builder::work(uint64_t tests) const {
    const uint64_t most = kMostTests + kMostTestsPerTriangle * triangles_.size();
    if (tests_.fetch_add(tests, std::memory_order_relaxed) + tests > most)
        throw OverBudget("max_depth must not cut triangles into countless pieces: at max_depth " +
                         std::to_string(max_depth_) + " and leaf_size " +
                         std::to_string(settings_.leaf_size) + " the tree over " +
                         std::to_string(triangles_.size()) + " triangles takes more than " +
                         std::to_string(most) + " tests of a triangle and a cell: lower max_depth or raise " +
                         "leaf_size");
}

void Builder::spend(uint64_t bytes) {
    if (bytes_.fetch_add(bytes, std::memory_order_relaxed) + bytes > settings_.max_bytes)
        throw OverBudget("max_bytes must hold the tree, got " + std::to_string(settings_.max_bytes) +
                         " for " + std::to_string(triangles_.size()) + " triangles at max_depth " +
                         std::to_string(max_depth_) + " and leaf_size " +
                         std::to_string(settings_.leaf_size) + ": lower max_depth or raise leaf_size");
}

void Builder::leaf(const Task& task, size_t at, BspTree& tree) {
    spend(task.ids.size() * sizeof(uint32_t));
    tree.nodes[at] = BspNode::leaf(uint32_t(tree.ids.size()), uint32_t(task.ids.size()));
    tree.ids.insert(tree.ids.end(), task.ids.begin(), task.ids.end());
    tree.depth = std::max(tree.depth, task.depth);
}

void Builder::subtree(Task task, size_t root, BspTree& tree) {
    std::optional<Halves> halves = halve(task);
    if (!halves) return leaf(task, root, tree);
    task.ids = {};
    spend(2 * sizeof(BspNode));
    const size_t children = tree.nodes.size();
    tree.nodes[root] = BspNode::inner(halves->axis, halves->plane, uint32_t(children));
    tree.nodes.resize(children + 2);
    subtree(std::move(halves->low), children, tree);
    subtree(std::move(halves->high), children + 1, tree);
}

/// Attaches a subtree, whose root is its node 0, at node `at` of the whole tree.
void attach(BspTree& whole, size_t at, const BspTree& part) {
    // Node 0 replaces `at`; node i > 0 moves to shift + i
    const uint32_t shift = uint32_t(whole.nodes.size()) - 1, first_id = uint32_t(whole.ids.size());
    const auto moved = [&](BspNode n) {
        return n.is_leaf() ? BspNode::leaf(n.first() + first_id, n.count())
                           : BspNode::inner(n.axis(), n.plane(), n.children() + shift);
    };
    whole.nodes[at] = moved(part.nodes[0]);
    for (size_t i = 1; i < part.nodes.size(); ++i) whole.nodes.push_back(moved(part.nodes[i]));
    whole.ids.insert(whole.ids.end(), part.ids.begin(), part.ids.end());
    whole.depth = std::max(whole.depth, part.depth);
}

/// Halves cells level by level until there are enough subtrees to build in parallel. Their roots start at
/// `first`.
std::vector<std::pair<size_t, Task>> build_top(const Builder& builder, Task all, BspTree& tree) {
    std::vector<std::pair<size_t, Task>> level;
    level.emplace_back(0, std::move(all));
    for (bool halved = true; halved && level.size() < kSubtrees;) {
        halved = false;
        std::vector<std::pair<size_t, Task>> next;
        for (auto& [at, task] : level) {
            std::optional<Halves> halves = builder.halve(task);
            if (!halves) {
                next.emplace_back(at, std::move(task));
                continue;
            }
            halved = true;
            const size_t children = tree.nodes.size();
            tree.nodes[at] = BspNode::inner(halves->axis, halves->plane, uint32_t(children));
            tree.nodes.resize(children + 2);
            next.emplace_back(children, std::move(halves->low));
            next.emplace_back(children + 1, std::move(halves->high));
        }
        level = std::move(next);
    }
    return level;
}

/// Reorders nodes: the children and grandchildren of every other level become adjacent, so that a descent
/// touches one cache line per two levels.
std::vector<BspNode> clustered(const std::vector<BspNode>& nodes) {
    std::vector<BspNode> out{nodes[0]};
    out.reserve(nodes.size());
    // Positions of nodes that are placed already; their children still have their old index
    std::vector<uint32_t> roots{0};
    const auto place_children = [&](uint32_t at) {
        const BspNode n = out[at];
        const auto children = uint32_t(out.size());
        out.push_back(nodes[n.children()]);
        out.push_back(nodes[n.children() + 1]);
        out[at] = BspNode::inner(n.axis(), n.plane(), children);
        return children;
    };
    while (!roots.empty()) {
        const uint32_t root = roots.back();
        roots.pop_back();
        if (out[root].is_leaf()) continue;
        const uint32_t children = place_children(root);
        for (uint32_t child : {children, children + 1}) {
            if (out[child].is_leaf()) continue;
            const uint32_t grandchildren = place_children(child);
            roots.push_back(grandchildren);
            roots.push_back(grandchildren + 1);
        }
    }
    return out;
}

/// True if the projections on `axis` are disjoint. The corners are relative to the centre of the box.
bool apart(Vec3 axis, Vec3 half, Vec3 a, Vec3 b, Vec3 c) {
    const float pa = dot(axis, a), pb = dot(axis, b), pc = dot(axis, c);
    const float reach = std::fabs(axis.x) * half.x + std::fabs(axis.y) * half.y + std::fabs(axis.z) * half.z;
    return std::min({pa, pb, pc}) > reach || std::max({pa, pb, pc}) < -reach;
}

}  // namespace

// Separating axes [Akenine-Möller 2001]. NaN and overflow never separate.
bool triangle_meets_box(const FlatTriangle& triangle, Vec3 center, Vec3 half) {
    const Vec3 a = triangle.a - center, b = triangle.b - center, c = triangle.c - center;
    const Vec3 lo = min(min(a, b), c), hi = max(max(a, b), c);
    if (lo.x > half.x || lo.y > half.y || lo.z > half.z || hi.x < -half.x || hi.y < -half.y || hi.z < -half.z)
        return false;
    const Vec3 edges[3] = {b - a, c - b, a - c};
    if (apart(cross(edges[0], edges[1]), half, a, b, c)) return false;
    for (Vec3 e : edges)
        for (Vec3 axis : {Vec3{0, -e.z, e.y}, Vec3{e.z, 0, -e.x}, Vec3{-e.y, e.x, 0}})
            if (apart(axis, half, a, b, c)) return false;
    return true;
}

int BspSettings::depth(size_t n) const {
    if (max_depth > 0) return max_depth;
    return std::min(kMostBspDepth, int(std::lround(5 + std::log2(double(std::max<size_t>(1, n))))));
}

BspTree build_bsp(std::span<const FlatTriangle> triangles, const BspSettings& settings, int threads,
                  const Control& control) {
    settings.validate();
    BspTree tree;
    tree.max_depth = settings.depth(triangles.size());
    if (triangles.empty()) return tree;
    for (const FlatTriangle& t : triangles) tree.bounds.add(t.bounds());
    const float pad = kCellUlps * kUlp * tree.bounds.magnitude();
    tree.bounds.lo = tree.bounds.lo - Vec3{pad, pad, pad};
    tree.bounds.hi = tree.bounds.hi + Vec3{pad, pad, pad};
    Builder builder(triangles, settings, tree.max_depth, pad, control);
    Task all{std::vector<uint32_t>(triangles.size()), tree.bounds, 0, 0};
    std::iota(all.ids.begin(), all.ids.end(), 0u);
    tree.nodes.resize(1);
    auto tasks = build_top(builder, std::move(all), tree);
    std::vector<BspTree> parts(tasks.size());
    parallel_for(tasks.size(), threads, [&](size_t i, int) {
        parts[i].nodes.resize(1);
        builder.subtree(std::move(tasks[i].second), 0, parts[i]);
    });
    for (size_t i = 0; i < parts.size(); ++i) attach(tree, tasks[i].first, std::exchange(parts[i], {}));
    tree.nodes = clustered(tree.nodes);
    return tree;
}

}  // namespace viscache

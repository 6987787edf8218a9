#include "viscache/shafts/shaft_tree.h"

#include "viscache/shafts/shaft_parts.h"

namespace viscache {

namespace {

/// Nodes of the largest parts below other parts. What a thread has made is a tree of its own until it is
/// joined.
class Widener {
public:
    Widener(std::span<const ShaftTriangle> triangles, const ShaftParts& parts, const Control& control)
        : triangles_(triangles), parts_(parts), control_(control) {}

    /// The parts that become the children of a node.
    std::vector<int32_t> kids_of(int32_t top) const {
        std::vector<int32_t> kids{top};
        while (kids.size() < kShaftLanes) {
            size_t largest = kids.size();
            for (size_t i = 0; i < kids.size(); ++i) {
                if (part(kids[i]).is_leaf()) continue;
                const bool first = largest == kids.size();
                if (first || part(kids[i]).box.half_area() > part(kids[largest]).box.half_area()) largest = i;
            }
            if (largest == kids.size()) break;
            const ShaftPart& opened = part(kids[largest]);
            kids[largest] = opened.left;
            kids.push_back(opened.right);
        }
        return kids;
    }

    /// Adds the node of a part to a tree. make(part) adds the subtree of a child and returns its index.
    template <class Make>
    int32_t widen(ShaftTree& tree, int32_t top, Make make) const {
        control_.check();
        const std::vector<int32_t> kids = kids_of(top);
        const size_t index = tree.nodes.size();
        tree.nodes.push_back(ShaftNode{});
        for (size_t lane = 0; lane < kids.size(); ++lane) {
            const ShaftPart& kid = part(kids[lane]);
            const int32_t child = kid.is_leaf() ? ~add_block(tree, kid) : make(kids[lane]);
            ShaftNode& node = tree.nodes[index];
            for (int x = 0; x < 3; ++x) {
                node.lo[x][lane] = kid.box.lo[x];
                node.hi[x][lane] = kid.box.hi[x];
            }
            node.size[lane] = max_component(kid.box.hi - kid.box.lo);
            node.width[lane] = kid.width;
            node.child[lane] = child;
            node.used |= 1u << lane;
            if (kid.is_leaf()) node.leaves |= 1u << lane;
        }
        return int32_t(index);
    }
    /// The same with everything below.
    int32_t widen_all(ShaftTree& tree, int32_t top) const {
        return widen(tree, top, [&](int32_t kid) { return widen_all(tree, kid); });
    }
    const ShaftPart& part(int32_t i) const { return parts_.parts[size_t(i)]; }

private:
    int32_t add_block(ShaftTree& tree, const ShaftPart& leaf) const {
        ShaftBlock block{};
        for (uint32_t lane = 0; lane < kShaftLanes; ++lane) {
            const bool in = lane < leaf.count;
            const ShaftTriangle& t = triangles_[parts_.order[leaf.first + (in ? lane : 0)]];
            for (int c = 0; c < 9; ++c) block.corner[c][lane] = in ? t.corner[c / 3][c % 3] : std::nanf("");
            // One more ulp than the rounding of the double
            block.longest[lane] = std::max(float(longest_side(t)) * 1.000001f, kShortestSide);
            if (in) block.used |= 1u << lane;
            if (in && !t.solid) block.holed |= 1u << lane;
        }
        tree.blocks.push_back(block);
        return int32_t(tree.blocks.size() - 1);
    }

    std::span<const ShaftTriangle> triangles_;
    const ShaftParts& parts_;
    const Control& control_;
};

/// Appends a tree; returns the index of its root.
int32_t append_subtree(ShaftTree& tree, const ShaftTree& more) {
    const auto nodes = int32_t(tree.nodes.size()), blocks = int32_t(tree.blocks.size());
    for (ShaftNode node : more.nodes) {
        for (size_t lane = 0; lane < kShaftLanes; ++lane)
            if (node.used >> lane & 1) node.child[lane] += node.leaves >> lane & 1 ? -blocks : nodes;
        tree.nodes.push_back(node);
    }
    tree.blocks.insert(tree.blocks.end(), more.blocks.begin(), more.blocks.end());
    return nodes;
}

/// Threads make the subtrees two levels below the root; joined in the order of their places, they are the
/// tree of one thread.
ShaftTree widen_parts(std::span<const ShaftTriangle> triangles, const ShaftParts& parts, int threads,
                      const Control& control) {
    const Widener widener(triangles, parts, control);
    std::vector<int32_t> tops;
    for (const int32_t kid : widener.kids_of(0))
        if (!widener.part(kid).is_leaf())
            for (const int32_t below : widener.kids_of(kid))
                if (!widener.part(below).is_leaf()) tops.push_back(below);
    std::vector<ShaftTree> subtrees(tops.size());
    parallel_for(tops.size(), threads, [&](size_t i, int) { widener.widen_all(subtrees[i], tops[i]); });
    ShaftTree tree;
    size_t nodes = 1 + kShaftLanes, blocks = kShaftLanes * kShaftLanes;
    for (const ShaftTree& s : subtrees) {
        nodes += s.nodes.size();
        blocks += s.blocks.size();
    }
    tree.nodes.reserve(nodes);
    tree.blocks.reserve(blocks);
    size_t next = 0;
    widener.widen(tree, 0, [&](int32_t kid) {
        return widener.widen(tree, kid, [&](int32_t) {
            const int32_t index = append_subtree(tree, subtrees[next]);
            subtrees[next++] = {};
            return index;
        });
    });
    tree.bounds = widener.part(0).box;
    return tree;
}

}  // namespace

uint64_t most_shaft_bytes(uint64_t triangles) {
    // The price of a cut keeps blocks at least half full on average, and a node has at least eight children
    const uint64_t blocks = triangles / (kShaftLanes / 2) + 1;
    return blocks * sizeof(ShaftBlock) + (blocks / 8 + 2) * sizeof(ShaftNode);
}

ShaftTree build_shaft_tree(std::span<const ShaftTriangle> triangles, int threads, const Control& control) {
    if (!triangles.empty())
        return widen_parts(triangles, split_into_parts(triangles, threads, control), threads, control);
    ShaftTree tree;
    tree.nodes.push_back(ShaftNode{});
    return tree;
}

}  // namespace viscache

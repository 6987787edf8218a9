#pragma once
// A kd-tree over the positions of records that supports insertion of single points.
//
// Search results do not depend on the shape of the tree: of records at equal distance, the one with the
// lower id counts as nearer. Nothing here locks.
#include <vector>

#include "viscache/vismap/nearest_set.h"

namespace viscache {

class KdTree {
public:
    static constexpr size_t kLeafSize = 4;

    size_t size() const { return size_; }
    /// Changes with every modification.
    uint64_t version() const { return version_; }
    size_t rebuilds() const { return rebuilds_; }
    int depth() const { return depth_; }
    /// Number of leaves with more than kLeafSize coincident points.
    size_t oversized_leaves() const { return oversized_; }

    void clear();
    /// Replaces all points and balances the tree.
    void build(std::vector<TreePoint> points);
    /// Adds a point to the leaf that encloses it. A leaf that grows too large is split at the median of its
    /// longest axis. The tree is rebuilt when it holds 1.5 times as many points as at the last rebuild, or
    /// when it is deeper than 2 log2(size) + 8.
    void insert(const TreePoint& point);
    /// Offers every point in reach with accept(TreePoint) to the set.
    template <class Accept>
    void search(Vec3 position, Accept accept, NearestSet& nearest) const {
        if (size_) search(0, position, accept, nearest);
    }
    /// Calls visit(TreePoint, distance²) for every point within `radius`, in no particular order.
    template <class Visit>
    void visit(Vec3 position, float radius, Visit visit) const {
        if (size_) this->visit(0, position, radius * radius, visit);
    }

private:
    // 12 bytes: siblings mostly share a cache line.
    struct Node {
        float split = 0;
        int axis = kLeaf;
        uint32_t first = 0;  ///< left child, the right one follows; for a leaf its first block
    };
    /// Points of a leaf. A leaf that cannot be split has several blocks.
    struct Block {
        std::array<TreePoint, kLeafSize> points;
        uint32_t count = 0, next = kNone;
    };
    struct Cut {
        int axis;
        float split;  ///< smaller coordinates are on the left
    };
    static constexpr int kLeaf = -1;
    static constexpr uint32_t kNone = 0xffffffffu;

    static bool find_cut(std::span<TreePoint> points, Cut& cut);
    static size_t partition(std::span<TreePoint> points, const Cut& cut);
    void build_node(uint32_t node, std::span<TreePoint> points, int depth);
    void fill_leaf(uint32_t node, std::span<const TreePoint> points);
    std::vector<TreePoint> leaf_points(uint32_t node) const;
    std::vector<TreePoint> all_points() const;

    template <class Accept>
    void search(uint32_t index, Vec3 x, Accept accept, NearestSet& nearest) const {
        const Node& node = nodes_[index];
        if (node.axis == kLeaf) {
            for (uint32_t b = node.first; b != kNone; b = blocks_[b].next)
                for (uint32_t i = 0; i < blocks_[b].count; ++i) {
                    const TreePoint& p = blocks_[b].points[i];
                    const float d2 = length2(p.position - x);
                    if (d2 <= nearest.reach2() && accept(p)) nearest.offer(d2, p);
                }
            return;
        }
        // Rounding is monotonic, so no point beyond the plane is nearer than the plane, in floats as well
        const float beyond = x[node.axis] - node.split;
        const uint32_t near = node.first + (beyond >= 0);
        search(near, x, accept, nearest);
        // The sibling of `near`: both indices add up to 2 · first + 1.
        if (beyond * beyond <= nearest.reach2()) search(2 * node.first + 1 - near, x, accept, nearest);
    }

    template <class Visit>
    void visit(uint32_t index, Vec3 x, float radius2, Visit visit) const {
        const Node& node = nodes_[index];
        if (node.axis == kLeaf) {
            for (uint32_t b = node.first; b != kNone; b = blocks_[b].next)
                for (uint32_t i = 0; i < blocks_[b].count; ++i) {
                    const float d2 = length2(blocks_[b].points[i].position - x);
                    if (d2 <= radius2) visit(blocks_[b].points[i], d2);
                }
            return;
        }
        const float beyond = x[node.axis] - node.split;
        const uint32_t near = node.first + (beyond >= 0);
        this->visit(near, x, radius2, visit);
        if (beyond * beyond <= radius2) this->visit(2 * node.first + 1 - near, x, radius2, visit);
    }

    std::vector<Node> nodes_;
    std::vector<Block> blocks_;
    size_t size_ = 0, built_size_ = 0, rebuilds_ = 0, oversized_ = 0;
    int depth_ = 0, built_depth_ = 0;
    uint64_t version_ = 0;
};

}  // namespace viscache

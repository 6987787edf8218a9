#include "viscache/vismap/kd_tree.h"

#include <bit>

namespace viscache {

namespace {

constexpr size_t kSmall = 32;  // below this size the shape of the tree does not matter

/// Depth above which the tree counts as unbalanced.
int depth_limit(size_t n) { return 2 * int(std::bit_width(n)) + 8; }

}  // namespace

/// The version survives, so that lists made from the old tree know that they are outdated.
void KdTree::clear() {
    const uint64_t version = version_;
    *this = {};
    version_ = version + 1;
}

/// Returns false if all points coincide.
bool KdTree::find_cut(std::span<TreePoint> points, Cut& cut) {
    Vec3 lo = points[0].position, hi = lo;
    for (const TreePoint& p : points) {
        lo = min(lo, p.position);
        hi = max(hi, p.position);
    }
    const Vec3 extent = hi - lo;
    // The longest side: cells stay compact, and a ball of radius d_max meets few of them.
    cut.axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
    const auto coordinate = [&](const TreePoint& p) { return p.position[cut.axis]; };
    if (!(hi[cut.axis] > lo[cut.axis])) return false;
    const auto middle = points.begin() + std::ptrdiff_t(points.size() / 2);
    std::nth_element(points.begin(), middle, points.end(),
                     [&](const TreePoint& a, const TreePoint& b) { return coordinate(a) < coordinate(b); });
    cut.split = coordinate(*middle);
    // The left side must not be empty: if the median is the smallest coordinate, take the next one
    if (cut.split == lo[cut.axis]) {
        cut.split = hi[cut.axis];
        for (const TreePoint& p : points)
            if (coordinate(p) > lo[cut.axis]) cut.split = std::min(cut.split, coordinate(p));
    }
    return true;
}

/// Number of points on the left, which come first.
size_t KdTree::partition(std::span<TreePoint> points, const Cut& cut) {
    const auto middle = std::partition(points.begin(), points.end(),
                                       [&](const TreePoint& p) { return p.position[cut.axis] < cut.split; });
    return size_t(middle - points.begin());
}

void KdTree::fill_leaf(uint32_t node, std::span<const TreePoint> points) {
    nodes_[node].axis = kLeaf;
    // A leaf that grows keeps its blocks, which are written over.
    if (nodes_[node].first == 0) {  // a new leaf; block 0 stays unused
        nodes_[node].first = uint32_t(blocks_.size());
        blocks_.emplace_back();
    }
    oversized_ += points.size() > kLeafSize;
    uint32_t block = nodes_[node].first;
    for (size_t i = 0; i < points.size(); ++i) {
        // Full: go on in the next block, which may exist from before.
        if (i && i % kLeafSize == 0) {
            if (blocks_[block].next == kNone) {
                blocks_[block].next = uint32_t(blocks_.size());
                blocks_.emplace_back();
            }
            block = blocks_[block].next;
        }
        blocks_[block].points[i % kLeafSize] = points[i];
        blocks_[block].count = uint32_t(i % kLeafSize + 1);
    }
}

void KdTree::build_node(uint32_t node, std::span<TreePoint> points, int depth) {
    // The deepest leaf counts, since searches descend to leaves.
    depth_ = std::max(depth_, depth);
    Cut cut;
    if (points.size() <= kLeafSize || !find_cut(points, cut)) {
        fill_leaf(node, points);
        return;
    }
    const size_t left = partition(points, cut);
    // Siblings lie side by side, so one index names both.
    const uint32_t children = uint32_t(nodes_.size());
    nodes_.resize(nodes_.size() + 2);
    nodes_[node] = {cut.split, cut.axis, children};
    build_node(children, points.first(left), depth + 1);
    build_node(children + 1, points.subspan(left), depth + 1);
}

void KdTree::build(std::vector<TreePoint> points) {
    nodes_.assign(1, {});
    blocks_.assign(1, {});
    size_ = built_size_ = points.size();
    depth_ = 0;
    oversized_ = 0;
    ++rebuilds_;
    ++version_;
    build_node(0, points, 0);
    built_depth_ = depth_;
}

std::vector<TreePoint> KdTree::leaf_points(uint32_t node) const {
    std::vector<TreePoint> points;
    for (uint32_t b = nodes_[node].first; b != kNone; b = blocks_[b].next)
        points.insert(points.end(), blocks_[b].points.begin(), blocks_[b].points.begin() + blocks_[b].count);
    return points;
}

std::vector<TreePoint> KdTree::all_points() const {
    std::vector<TreePoint> points;
    points.reserve(size_ + 1);
    // Blocks that no leaf uses any more have count 0.
    for (const Block& b : blocks_) points.insert(points.end(), b.points.begin(), b.points.begin() + b.count);
    return points;
}

void KdTree::insert(const TreePoint& point) {
    // An occasional rebuild includes the new point
    // Each rebuild comes after half as many insertions again, so n insertions cost O(n log n) in total.
    const bool grown = size_ + 1 > kSmall && 2 * (size_ + 1) >= 3 * built_size_;
    // Coincident coordinates may leave even a new tree deep. It is rebuilt only if it has grown by 8 levels
    // since.
    const bool deep = depth_ > std::max(depth_limit(size_), built_depth_ + 8);
    if (!size_ || grown || deep) {
        std::vector<TreePoint> points = all_points();
        points.push_back(point);
        build(std::move(points));
        return;
    }
    ++version_;
    uint32_t node = 0;
    int depth = 0;
    // A coordinate equal to the split goes right, as in the partition.
    for (; nodes_[node].axis != kLeaf; ++depth)
        node = nodes_[node].first + (point.position[nodes_[node].axis] >= nodes_[node].split);
    std::vector<TreePoint> points = leaf_points(node);
    // Counted again by `fill_leaf` if the leaf stays too large.
    oversized_ -= points.size() > kLeafSize;
    points.push_back(point);
    ++size_;
    Cut cut;
    if (points.size() <= kLeafSize || !find_cut(points, cut)) {
        fill_leaf(node, points);
        return;
    }
    const size_t left = partition(points, cut);
    const uint32_t children = uint32_t(nodes_.size()), old_blocks = nodes_[node].first;
    // The left child takes over the blocks, which must be empty before they are filled again.
    for (uint32_t b = old_blocks; b != kNone; b = blocks_[b].next) blocks_[b].count = 0;
    nodes_.resize(nodes_.size() + 2);
    nodes_[children].first = old_blocks;
    nodes_[node] = {cut.split, cut.axis, children};
    fill_leaf(children, std::span<const TreePoint>(points).first(left));
    fill_leaf(children + 1, std::span<const TreePoint>(points).subspan(left));
    depth_ = std::max(depth_, depth + 1);
}

}  // namespace viscache

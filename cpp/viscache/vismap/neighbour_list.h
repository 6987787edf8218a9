#pragma once
// What was around the point asked for last: points that ask one after another mostly find the same records.
#include <algorithm>
#include <vector>

#include "viscache/vismap/kd_tree.h"

namespace viscache {

/// Answers searches of one tree like the tree itself. Between them it keeps the tree's points around a place,
/// nearest first; where they cannot be all that a search must see, it asks the tree. For one thread.
class NeighbourList {
public:
    /// Offers to `nearest`, which is empty, points that accept(TreePoint) lets pass until it holds what
    /// KdTree::search would have left in it.
    template <class Accept>
    void search(const KdTree& tree, Vec3 x, Accept accept, NearestSet& nearest) {
        if (version_ != tree.version()) forget(tree);
        const Vec3 before = asked_;
        asked_ = x;
        const float moved = length(x - centre_);
        if (!entries_.empty() && search_entries(x, moved, accept, nearest)) {
            ++answered_, worth_ = std::min(worth_ + 1, kMostWorth);
            return;
        }
        nearest.clear();
        tree.search(x, accept, nearest);
        // A list pays where the next points are near, and the lists before it answered as many searches as
        // making one costs; where they did not, one is tried from time to time
        const float reach2 = nearest.reach2();
        if (!(length2(x - before) < kNear * kNear * reach2)) return;
        if (worth_ < 0 && ++unlisted_ < kSeldom) return;
        fill(tree, x, kMargin * std::sqrt(reach2));
        worth_ -= kCost, unlisted_ = 0;
    }
    /// Searches that did not need the tree.
    uint64_t answered() const { return answered_; }

private:
    static constexpr float kMargin = 2;  ///< radius of the list over the reach of a search
    static constexpr float kNear = 1;    ///< step between points, in reaches, up to which a list is made
    static constexpr float kRounding = 1e-5f;  ///< distances in floats differ by less, relatively
    static constexpr int kCost = 5, kMostWorth = 10, kSeldom = 20;  ///< in searches of the tree
    struct Entry {
        float distance;  ///< from the centre
        TreePoint point;
    };

    void forget(const KdTree& tree) {
        version_ = tree.version(), entries_.clear(), asked_ = {kInfinity, 0, 0};
    }

    void fill(const KdTree& tree, Vec3 x, float radius) {
        centre_ = x, radius_ = radius;
        entries_.clear();
        tree.visit(x, radius, [&](const TreePoint& p, float d2) { entries_.push_back({std::sqrt(d2), p}); });
        std::sort(entries_.begin(), entries_.end(),
                  [](const Entry& a, const Entry& b) { return a.distance < b.distance; });
    }

    /// False where the tree may know a nearer one.
    template <class Accept>
    bool search_entries(Vec3 x, float moved, Accept accept, NearestSet& nearest) const {
        const float known = radius_ * (1 - kRounding) - moved * (1 + kRounding);
        if (!(known > 0)) return false;
        for (const Entry& e : entries_) {
            const float least = e.distance * (1 - kRounding) - moved * (1 + kRounding);
            if (least > 0 && least * least > nearest.reach2()) break;
            const float d2 = length2(e.point.position - x);
            if (d2 <= nearest.reach2() && accept(e.point)) nearest.offer(d2, e.point);
        }
        return nearest.reach2() < known * known;
    }

    uint64_t version_ = ~uint64_t(0), answered_ = 0;
    Vec3 centre_, asked_{kInfinity, 0, 0};
    float radius_ = 0;
    int worth_ = 0, unlisted_ = 0;
    std::vector<Entry> entries_;
};

}  // namespace viscache

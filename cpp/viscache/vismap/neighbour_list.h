#pragma once
// A list of the points around the previous queries: consecutive queries mostly find the same records.
#include <algorithm>
#include <vector>

#include "viscache/vismap/kd_tree.h"

namespace viscache {

/// Answers searches of one tree with the same results as the tree. It keeps the tree's points around a
/// centre, sorted by distance. If the list may not contain all points that a search needs, the tree is
/// searched. For use by one thread.
class NeighbourList {
public:
    /// `nearest` must be empty. Fills it with the points that KdTree::search would find, given
    /// accept(TreePoint).
    template <class Accept>
    void search(const KdTree& tree, Vec3 x, Accept accept, NearestSet& nearest) {
        // Of the tree, the list has everything within `radius` of the centre, so everything within `known` of
        // x:
        //
        //     centre *---- moved ----* x
        //     |<---------- radius ---------->|
        //                            |<known>|
        //
        // A set that is complete within `known` is that of the tree. Otherwise the tree is searched.
        if (version_ != tree.version()) forget(tree);
        const Vec3 before = asked_;
        asked_ = x;
        const float moved = length(x - centre_);
        if (!entries_.empty() && search_entries(x, moved, accept, nearest)) {
            ++answered_;
            // Every answer repays a part of what the list has cost, up to a limit: a good past must not pay
            // for long for lists that no longer help.
            balance_ = std::min(balance_ + 1, kMaxBalance);
            return;
        }
        nearest.clear();
        tree.search(x, accept, nearest);
        // A new list pays off if queries are close together and if the previous lists answered enough
        // searches to repay their cost. Otherwise a list is tried only from time to time
        const float reach2 = nearest.reach2();
        if (!(length2(x - before) < kNear * kNear * reach2)) return;
        if (balance_ < 0 && ++unlisted_ < kSeldom) return;
        // Twice the reach: about that far queries may move before the list is useless.
        fill(tree, x, kMargin * std::sqrt(reach2));
        balance_ -= kCost;
        unlisted_ = 0;
    }
    /// Number of searches answered without the tree.
    uint64_t answered() const { return answered_; }

private:
    static constexpr float kMargin = 2;  ///< radius of the list relative to the reach of a search
    static constexpr float kNear =
        1;  ///< maximum step between queries, in reaches, for which a list is built
    static constexpr float kRounding = 1e-5f;  ///< bound of the relative rounding error of distances
    static constexpr int kCost = 5, kMaxBalance = 10, kSeldom = 20;  ///< in searches of the tree
    struct Entry {
        float distance;  ///< from the centre
        TreePoint point;
    };

    void forget(const KdTree& tree) {
        version_ = tree.version();
        entries_.clear();
        asked_ = {kInfinity, 0, 0};
    }

    void fill(const KdTree& tree, Vec3 x, float radius) {
        centre_ = x;
        radius_ = radius;
        entries_.clear();
        tree.visit(x, radius, [&](const TreePoint& p, float d2) { entries_.push_back({std::sqrt(d2), p}); });
        std::sort(entries_.begin(), entries_.end(),
                  [](const Entry& a, const Entry& b) { return a.distance < b.distance; });
    }

    /// Returns false if the tree may contain nearer points.
    template <class Accept>
    bool search_entries(Vec3 x, float moved, Accept accept, NearestSet& nearest) const {
        const float known = radius_ * (1 - kRounding) - moved * (1 + kRounding);
        if (!(known > 0)) return false;
        for (const Entry& e : entries_) {
            // Triangle inequality: how near to x this entry and all later ones can be.
            const float least = e.distance * (1 - kRounding) - moved * (1 + kRounding);
            if (least > 0 && least * least > nearest.reach2()) break;
            const float d2 = length2(e.point.position - x);
            if (d2 <= nearest.reach2() && accept(e.point)) nearest.offer(d2, e.point);
        }
        // A set that is not full has the radius of the search as its reach, and must be known up to there.
        return nearest.reach2() < known * known;
    }

    uint64_t version_ = ~uint64_t(0), answered_ = 0;
    Vec3 centre_, asked_{kInfinity, 0, 0};
    float radius_ = 0;
    int balance_ = 0, unlisted_ = 0;
    std::vector<Entry> entries_;
};

}  // namespace viscache

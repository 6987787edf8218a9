#pragma once
// Postponed rays (AQVC Sec. 4.4): the work queue of a GPU warp, on the CPU.
#include <cstdint>
#include <vector>

#include "viscache/aqvc/cluster_key.h"

namespace viscache {

/// A ray to be traced: for the first query with its key, or for a query that bypasses the cache.
struct PendingRay {
    uint32_t query;
    int level;  ///< -1: bypass
    FullKey key;
};
/// A query that depends on a ray.
struct Dependant {
    uint32_t query, ray;
};

/// [AQVC Sec. 4.4] A warp has half as many queries as the queue has entries; its queries look up their values
/// at once. If fewer than C_W rays are missing, they are postponed; otherwise they are traced at once. If
/// more than half of the queue is occupied, its first half is processed: the rays are traced, their values
/// are written to the cache, and the queries that depend on them are answered.
// Differs (A42): a query whose key is in the queue shares the ray of that entry; the paper traces the ray
// twice. A warp consists of consecutive queries, not of pixels. Entries left at the end of a call are
// processed then.
class PostponedQueue {
public:
    explicit PostponedQueue(int length) : width_(size_t(length) / 2) {}

    /// Queries per warp, and entries that are processed together.
    size_t width() const { return width_; }
    /// Index of the ray with this key; rays.size() if there is none.
    uint32_t find(const FullKey& key) const {
        // The queue is short, so a search from the front is enough.
        size_t r = 0;
        while (r < rays.size() && (rays[r].level < 0 || rays[r].key != key)) ++r;
        return uint32_t(r);
    }
    /// Called after a warp; its first new ray has index `first_new`. `finish(first, last)` traces rays
    /// [first, last) and answers the queries that depend on them. The rays are then removed.
    template <class Finish>
    void end_warp(size_t first_new, int c_w, Finish finish) {
        // A warp that misses much fills a packet at once: waiting would gain nothing.
        if (rays.size() - first_new >= size_t(c_w)) take(first_new, rays.size(), finish);
        while (rays.size() > width_) take(0, width_, finish);
    }
    template <class Finish>
    void finish_all(Finish finish) {
        take(0, rays.size(), finish);
    }

    std::vector<PendingRay> rays;       ///< in the order of insertion
    std::vector<Dependant> dependants;  ///< in the order of their queries

private:
    template <class Finish>
    void take(size_t first, size_t last, Finish finish) {
        if (first == last) return;
        finish(first, last);
        const auto at = [&](size_t i) { return rays.begin() + std::ptrdiff_t(i); };
        rays.erase(at(first), at(last));
        std::erase_if(dependants, [&](const Dependant& d) { return d.ray >= first && d.ray < last; });
        // Indices of later rays move down.
        for (Dependant& d : dependants) d.ray -= d.ray >= last ? uint32_t(last - first) : 0;
    }
    size_t width_;
};

}  // namespace viscache

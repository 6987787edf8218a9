#pragma once
// Rays that wait to be traced (AQVC Sec. 4.4): the queue of postponed work of a GPU's warp, on the CPU.
#include <algorithm>
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
/// A query that waits for a ray.
struct Dependant {
    uint32_t query, ray;
};

/// [AQVC Sec. 4.4] Half the queue's length of queries, a warp, look their values up at once. Are fewer than
/// C_W rays missing, they are postponed and the rest goes on; else they are traced at once. Where more than
/// half of the queue is taken, its first half is finished: the rays are shot, the cache is filled, and the
/// queries that wait are answered.
// Differs: a query whose key is in the queue waits for the ray that is there, where the paper shoots it
// twice; a warp is made of queries that follow each other, not of pixels; and what is left at the end of a
// call is finished then.
class PostponedQueue {
public:
    explicit PostponedQueue(int length) : width_(size_t(length) / 2) {}

    /// Queries of a warp, and entries that are finished together.
    size_t width() const { return width_; }
    /// Number of the ray with this key; rays.size() where there is none.
    uint32_t find(const FullKey& key) const {
        size_t r = 0;
        while (r < rays.size() && (rays[r].level < 0 || rays[r].key != key)) ++r;
        return uint32_t(r);
    }
    /// After a warp whose first new ray is number `first_new`. `finish(first, last)` shoots rays [first,
    /// last) and answers those who wait for them; they are removed afterwards.
    template <class Finish>
    void end_warp(size_t first_new, int c_w, Finish finish) {
        if (rays.size() - first_new >= size_t(c_w)) take(first_new, rays.size(), finish);
        while (rays.size() > width_) take(0, width_, finish);
    }
    template <class Finish>
    void finish_all(Finish finish) {
        take(0, rays.size(), finish);
    }

    std::vector<PendingRay> rays;       ///< in the order they came
    std::vector<Dependant> dependants;  ///< in the order of their queries

private:
    template <class Finish>
    void take(size_t first, size_t last, Finish finish) {
        if (first == last) return;
        finish(first, last);
        const auto at = [&](size_t i) { return rays.begin() + std::ptrdiff_t(i); };
        rays.erase(at(first), at(last));
        std::erase_if(dependants, [&](const Dependant& d) { return d.ray >= first && d.ray < last; });
        for (Dependant& d : dependants) d.ray -= d.ray >= last ? uint32_t(last - first) : 0;
    }
    size_t width_;
};

}  // namespace viscache

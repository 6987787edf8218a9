#include "viscache/vismap/insertion.h"

#include <cmath>
#include <limits>
#include <mutex>

namespace viscache {

namespace {

// Successive points are neighbours in the image, so a chunk profits from one NeighbourList.
constexpr size_t kPointsPerChunk = 64;

/// Calls work(first, last) over [0, n) in chunks, in parallel.
template <class Work>
void in_chunks(size_t n, int threads, const Control& control, Work work) {
    parallel_for((n + kPointsPerChunk - 1) / kPointsPerChunk, threads, [&](size_t chunk, int) {
        control.check();
        work(chunk * kPointsPerChunk, std::min(n, (chunk + 1) * kPointsPerChunk));
    });
}

/// Counts an inserted record by its reason.
void count_inserted(Verdict reason, InsertionStats& stats) {
    stats.no_candidate += reason == Verdict::kNoCandidate;
    stats.weight += reason == Verdict::kWeight;
    stats.difference += reason == Verdict::kDifference;
}

AmbientRecord clipped(AmbientRecord ambient, float footprint) {
    // Differs (M39): a hit nearer than a pixel would request new records forever
    ambient.nearest_hit = std::max(ambient.nearest_hit, footprint);
    return ambient;
}

/// Traces records at the chosen points and adds them in this order; duplicates are skipped.
struct Added {
    std::vector<uint32_t> points;
    uint64_t rays = 0;
};
Added add_records(MapCache& cache, const RecordTracer& tracer, std::span<const CachePoint> points,
                  std::span<const uint32_t> chosen, uint32_t frame, int threads, const Control& control) {
    std::vector<Vec3> positions, normals;
    for (uint32_t i : chosen) {
        positions.push_back(points[i].position);
        normals.push_back(points[i].normal);
    }
    // All rays of the round in one call: threads share them, whatever the number of records.
    const RecordTracer::Traced traced = tracer.trace(positions, normals, threads, control);
    Added added{{}, traced.rays};
    for (size_t k = 0; k < chosen.size(); ++k) {
        const CachePoint& point = points[chosen[k]];
        // Two chosen points may coincide. The check sees records that this loop has added.
        if (cache.has_duplicate(point)) continue;
        cache.add({positions[k], normals[k], 0, 0, frame}, traced.bits(k),
                  clipped(traced.ambient[k], point.footprint));
        added.points.push_back(chosen[k]);
    }
    return added;
}

/// Deterministic insertion; see insertion.h.
class Batches {
public:
    Batches(MapCache& cache, const RecordTracer& tracer, std::span<const CachePoint> points, uint32_t frame,
            int threads, Control& control, InsertionStats& stats, std::span<Verdict> verdicts)
        : cache_(cache),
          tracer_(tracer),
          points_(points),
          frame_(frame),
          threads_(threads),
          control_(control),
          stats_(stats),
          verdicts_(verdicts),
          cos_theta_max_(std::cos(cache.parameters().theta_max_rad())) {}

    void run(std::span<const uint32_t> usable) {
        // Smaller batches see records of earlier ones sooner; larger ones give threads more to do.
        const size_t most = cache_.parameters().batch;
        for (size_t first = 0; first < usable.size(); first += most) {
            const auto batch = usable.subspan(first, std::min(most, usable.size() - first));
            std::vector<uint32_t> pending(batch.begin(), batch.end());
            // Of each round, the first point that wants a record gets it, so the rounds come to an end.
            while (!pending.empty()) pending = round(pending);
            control_.done += batch.size();
        }
    }

private:
    /// One round. Returns the points to look up again.
    std::vector<uint32_t> round(std::span<const uint32_t> pending) {
        // Nothing changes during the look-ups, so their order is free.
        in_chunks(pending.size(), threads_, control_, [&](size_t first, size_t last) {
            NeighbourList around;
            for (size_t i = first; i < last; ++i) {
                const CachePoint& point = points_[pending[i]];
                verdicts_[pending[i]] = cache_.judge(point, cache_.select(point, around));
            }
        });
        stats_.lookups += pending.size();
        std::vector<uint32_t> accepted, again;
        // Decisions are made by one thread, in the order of the points: they depend on neither threads nor
        // timing.
        for (uint32_t i : pending) {
            if (!wants_record(verdicts_[i])) continue;
            // The cache is full, and this point stays without a record (`refused`).
            if (cache_.size() + accepted.size() >= cache_.parameters().max_records) continue;
            if (in_reach_of_any(i, accepted)) {
                again.push_back(i);
                continue;
            }
            count_inserted(verdicts_[i], stats_);
            // Its own record will serve it.
            verdicts_[i] = Verdict::kServed;
            accepted.push_back(i);
        }
        if (!accepted.empty())
            stats_.rays += add_records(cache_, tracer_, points_, accepted, frame_, threads_, control_).rays;
        return again;
    }
    /// True if a record at one of the other points would be a candidate for the point.
    /// The tests are those of MapCache::candidates.
    bool in_reach_of_any(uint32_t point, std::span<const uint32_t> others) const {
        const CachePoint& p = points_[point];
        const float reach2 = p.d_max * p.d_max;
        return std::any_of(others.begin(), others.end(), [&](uint32_t other) {
            const CachePoint& q = points_[other];
            return length2(q.position - p.position) < reach2 && dot(p.normal, q.normal) > cos_theta_max_;
        });
    }

    MapCache& cache_;
    const RecordTracer& tracer_;
    std::span<const CachePoint> points_;
    uint32_t frame_;
    int threads_;
    Control& control_;
    InsertionStats& stats_;
    std::span<Verdict> verdicts_;
    float cos_theta_max_;
};

/// The insertion of the paper: a thread adds its record at once, while it holds the lock exclusively.
void insert_locked(MapCache& cache, const RecordTracer& tracer, std::span<const CachePoint> points,
                   std::span<const uint32_t> usable, uint32_t frame, int threads, Control& control,
                   InsertionStats& stats, std::span<Verdict> verdicts) {
    std::mutex stats_mutex;
    in_chunks(usable.size(), threads, control, [&](size_t first, size_t last) {
        InsertionStats own;
        NeighbourList around;
        for (uint32_t i : usable.subspan(first, last - first)) {
            const CachePoint& point = points[i];
            // Both judgements use the list of one thread, which notices when the tree has changed.
            const auto judge = [&] { verdicts[i] = cache.judge(point, cache.select(point, around)); };
            {
                const std::shared_lock lock(cache.mutex());
                judge();
                if (!wants_record(verdicts[i]) || cache.full()) continue;
            }
            // Rays are traced without the lock; meanwhile another thread may have inserted a suitable record
            const RecordTracer::Traced traced =
                tracer.trace({&point.position, 1}, {&point.normal, 1}, 1, control);
            own.rays += traced.rays;
            const std::unique_lock lock(cache.mutex());
            judge();
            if (!wants_record(verdicts[i]) || cache.full()) continue;
            cache.add({point.position, point.normal, 0, 0, frame}, traced.bits(0),
                      clipped(traced.ambient[0], point.footprint));
            count_inserted(verdicts[i], own);
            verdicts[i] = Verdict::kServed;
        }
        // Locked once per chunk, not for each point
        const std::lock_guard lock(stats_mutex);
        stats.lookups += last - first;
        stats.rays += own.rays;
        stats.no_candidate += own.no_candidate;
        stats.weight += own.weight;
        stats.difference += own.difference;
        control.done += last - first;
    });
}

std::vector<uint32_t> usable_points(std::span<const CachePoint> points) {
    std::vector<uint32_t> usable;
    for (uint32_t i = 0; i < points.size(); ++i)
        if (points[i].usable()) usable.push_back(i);
    return usable;
}

/// The points whose lookup may find one of the records from `first_new` on.
std::vector<uint32_t> touched_points(const MapCache& cache, uint32_t first_new,
                                     std::span<const CachePoint> points, std::span<const uint32_t> usable,
                                     int threads, const Control& control) {
    std::vector<TreePoint> added;
    for (uint32_t id = first_new; id < cache.size(); ++id)
        added.push_back({cache.records().head(id).position, cache.records().head(id).normal, id});
    // A tree of only the new records: one of them in reach is enough, so the search stops at the nearest.
    KdTree tree;
    tree.build(std::move(added));
    // With the filter after the search, records of any normal can displace others
    const float least_cos = cache.parameters().filter == SearchFilter::kAfter
                                ? -kInfinity
                                : std::cos(cache.parameters().theta_max_rad());
    std::vector<uint8_t> is_touched(usable.size());
    in_chunks(usable.size(), threads, control, [&](size_t first, size_t last) {
        for (size_t i = first; i < last; ++i) {
            const CachePoint& point = points[usable[i]];
            NearestSet any(1, point.d_max);
            tree.search(
                point.position, [&](const TreePoint& p) { return dot(point.normal, p.normal) > least_cos; },
                any);
            is_touched[i] = !any.sorted().empty();
        }
    });
    std::vector<uint32_t> touched;
    for (size_t i = 0; i < usable.size(); ++i)
        if (is_touched[i]) touched.push_back(usable[i]);
    return touched;
}

}  // namespace

InsertionStats insert_where_needed(MapCache& cache, const RecordTracer& tracer,
                                   std::span<const CachePoint> points, uint32_t frame, int threads,
                                   Control& control) {
    const MapCacheParameters& parameters = cache.parameters();
    InsertionStats stats;
    const std::vector<uint32_t> usable = usable_points(points);
    stats.points = points.size();
    stats.unusable = points.size() - usable.size();
    std::vector<Verdict> verdicts(points.size(), Verdict::kServed);
    // The first pass looks up all points, each later one those that a new record may concern. A new record
    // can raise a point's mean difference, so passes repeat until one adds nothing.
    for (std::vector<uint32_t> pending = usable; !pending.empty();) {
        const auto first_new = uint32_t(cache.size());
        ++stats.passes;
        control.done = 0;
        control.total = pending.size();
        if (parameters.mode == InsertionMode::kBatch)
            Batches(cache, tracer, points, frame, threads, control, stats, verdicts).run(pending);
        else
            insert_locked(cache, tracer, points, pending, frame, threads, control, stats, verdicts);
        // One pass is the paper's insertion.
        if (!parameters.repeat_passes || cache.size() == first_new) break;
        pending = touched_points(cache, first_new, points, usable, threads, control);
    }
    for (Verdict v : verdicts) {
        stats.suppressed += v == Verdict::kSuppressed;
        stats.duplicates += v == Verdict::kDuplicate;
        stats.refused += wants_record(v);
    }
    return stats;
}

BootstrapStatistics bootstrap(MapCache& cache, const RecordTracer& tracer, std::span<const CachePoint> points,
                              uint32_t frame, int threads, Control& control) {
    BootstrapStatistics stats;
    std::vector<uint32_t> usable = usable_points(points);
    stats.unusable = points.size() - usable.size();
    const auto first_id = uint32_t(cache.size());
    // Start-up records beyond the limit are not traced at all.
    usable.resize(std::min<size_t>(usable.size(), cache.parameters().max_records - first_id));
    const Added added = add_records(cache, tracer, points, usable, frame, threads, control);
    stats.rays = added.rays;
    stats.duplicates = usable.size() - added.points.size();
    usable = added.points;
    stats.difference.resize(usable.size());
    stats.tested.resize(usable.size());
    in_chunks(usable.size(), threads, control, [&](size_t first, size_t last) {
        NeighbourList around;
        for (size_t i = first; i < last; ++i) {
            // Without its own record, each start-up point shows what the cache would have said there. Users
            // can choose w_min and delta_max by these statistics.
            const Selection s = cache.select(points[usable[i]], around, first_id + uint32_t(i));
            stats.tested[i] = s.tested;
            stats.difference[i] =
                s.count < 2 ? std::numeric_limits<float>::quiet_NaN() : cache.mean_difference(s);
        }
    });
    return stats;
}

}  // namespace viscache

#include "viscache/vismap/insertion.h"

#include <cmath>
#include <limits>
#include <mutex>

namespace viscache {

namespace {

constexpr size_t kPointsPerChunk = 64;

/// work(first, last) over [0, n) in chunks on threads.
template <class Work>
void in_chunks(size_t n, int threads, const Control& control, Work work) {
    parallel_for((n + kPointsPerChunk - 1) / kPointsPerChunk, threads, [&](size_t chunk, int) {
        control.check();
        work(chunk * kPointsPerChunk, std::min(n, (chunk + 1) * kPointsPerChunk));
    });
}

void count(Verdict verdict, InsertionStats& stats) {
    stats.no_candidate += verdict == Verdict::kNoCandidate;
    stats.weight += verdict == Verdict::kWeight;
    stats.difference += verdict == Verdict::kDifference;
    stats.suppressed += verdict == Verdict::kSuppressed;
    stats.duplicates += verdict == Verdict::kDuplicate;
}

AmbientRecord clipped(AmbientRecord ambient, float footprint) {
    // Differs: a hit nearer than a pixel would ask for records for ever
    ambient.nearest_hit = std::max(ambient.nearest_hit, footprint);
    return ambient;
}

/// Traces records at some of the points and adds them in this order, but for duplicates.
struct Added {
    std::vector<uint32_t> points;
    uint64_t rays = 0;
};
Added add_records(MapCache& cache, const RecordTracer& tracer, std::span<const CachePoint> points,
                  std::span<const uint32_t> chosen, uint32_t frame, int threads, const Control& control) {
    std::vector<Vec3> positions, normals;
    for (uint32_t i : chosen) positions.push_back(points[i].position), normals.push_back(points[i].normal);
    const RecordTracer::Traced traced = tracer.trace(positions, normals, threads, control);
    Added added{{}, traced.rays};
    for (size_t k = 0; k < chosen.size(); ++k) {
        const CachePoint& point = points[chosen[k]];
        if (cache.has_duplicate(point)) continue;
        cache.add({positions[k], normals[k], 0, 0, frame}, traced.bits(k),
                  clipped(traced.ambient[k], point.footprint));
        added.points.push_back(chosen[k]);
    }
    return added;
}

/// Deterministic insertion; see the head.
class Batches {
public:
    Batches(MapCache& cache, const RecordTracer& tracer, std::span<const CachePoint> points,
            const InsertionOptions& options, Control& control, InsertionStats& stats)
        : cache_(cache),
          tracer_(tracer),
          points_(points),
          options_(options),
          control_(control),
          stats_(stats),
          cos_theta_max_(std::cos(cache.parameters().theta_max_rad)) {}

    void run(std::span<const uint32_t> usable) {
        for (size_t first = 0; first < usable.size(); first += options_.batch) {
            const auto batch = usable.subspan(first, std::min(options_.batch, usable.size() - first));
            std::vector<uint32_t> pending(batch.begin(), batch.end());
            while (!pending.empty()) pending = round(pending);
            control_.done += batch.size();
        }
    }

private:
    /// One round; the points to be looked up again.
    std::vector<uint32_t> round(std::span<const uint32_t> pending) {
        std::vector<Verdict> verdicts(pending.size());
        in_chunks(pending.size(), options_.threads, control_, [&](size_t first, size_t last) {
            for (size_t i = first; i < last; ++i) {
                const CachePoint& point = points_[pending[i]];
                verdicts[i] = cache_.judge(point, cache_.select(point));
            }
        });
        stats_.lookups += pending.size();
        std::vector<uint32_t> accepted, again;
        for (size_t i = 0; i < pending.size(); ++i)
            if (!wants_record(verdicts[i]))
                count(verdicts[i], stats_);
            else if (cache_.size() + accepted.size() >= cache_.parameters().max_records)
                ++stats_.refused;
            else if (in_reach_of_any(pending[i], accepted))
                again.push_back(pending[i]);
            else
                accepted.push_back(pending[i]), count(verdicts[i], stats_);
        if (!accepted.empty())
            stats_.rays +=
                add_records(cache_, tracer_, points_, accepted, options_.frame, options_.threads, control_)
                    .rays;
        return again;
    }
    /// Whether a record at one of the others would be a candidate for the point.
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
    const InsertionOptions& options_;
    Control& control_;
    InsertionStats& stats_;
    float cos_theta_max_;
};

/// The paper's insertion: whoever holds the lock alone adds its record at once.
void insert_locked(MapCache& cache, const RecordTracer& tracer, std::span<const CachePoint> points,
                   std::span<const uint32_t> usable, const InsertionOptions& options, Control& control,
                   InsertionStats& stats) {
    std::mutex stats_mutex;
    in_chunks(usable.size(), options.threads, control, [&](size_t first, size_t last) {
        InsertionStats own;
        for (size_t i = first; i < last; ++i) {
            const CachePoint& point = points[usable[i]];
            const auto judged = [&] { return cache.judge(point, cache.select(point)); };
            Verdict verdict;
            {
                const std::shared_lock lock(cache.mutex());
                verdict = judged();
            }
            ++own.lookups;
            if (!wants_record(verdict)) {
                count(verdict, own);
                continue;
            }
            // Rays are traced outside the lock; another thread may meanwhile have served the point
            const RecordTracer::Traced traced =
                tracer.trace({&point.position, 1}, {&point.normal, 1}, 1, control);
            own.rays += traced.rays;
            const std::unique_lock lock(cache.mutex());
            verdict = judged();
            const bool full = cache.full();
            if (!wants_record(verdict) || !full) count(verdict, own);
            if (!wants_record(verdict)) continue;
            own.refused += full;
            if (!full)
                cache.add({point.position, point.normal, 0, 0, options.frame}, traced.bits(0),
                          clipped(traced.ambient[0], point.footprint));
        }
        const std::lock_guard lock(stats_mutex);
        stats.lookups += own.lookups, stats.rays += own.rays, stats.no_candidate += own.no_candidate;
        stats.weight += own.weight, stats.difference += own.difference;
        stats.suppressed += own.suppressed, stats.duplicates += own.duplicates, stats.refused += own.refused;
        control.done += last - first;
    });
}

std::vector<uint32_t> usable_points(std::span<const CachePoint> points) {
    std::vector<uint32_t> usable;
    for (uint32_t i = 0; i < points.size(); ++i)
        if (points[i].usable()) usable.push_back(i);
    return usable;
}

}  // namespace

InsertionStats insert_where_needed(MapCache& cache, const RecordTracer& tracer,
                                   std::span<const CachePoint> points, const InsertionOptions& options,
                                   Control& control) {
    InsertionStats stats;
    const std::vector<uint32_t> usable = usable_points(points);
    stats.points = points.size(), stats.unusable = points.size() - usable.size();
    for (size_t before = ~size_t{0}; cache.size() != before && (options.settle || !stats.passes);) {
        before = cache.size();
        ++stats.passes;
        stats.suppressed = stats.duplicates = stats.refused = 0;
        control.done = 0, control.total = usable.size();
        if (options.mode == InsertionMode::kBatch)
            Batches(cache, tracer, points, options, control, stats).run(usable);
        else
            insert_locked(cache, tracer, points, usable, options, control, stats);
    }
    return stats;
}

BootstrapStatistics bootstrap(MapCache& cache, const RecordTracer& tracer, std::span<const CachePoint> points,
                              uint32_t frame, int threads, Control& control) {
    BootstrapStatistics stats;
    std::vector<uint32_t> usable = usable_points(points);
    stats.unusable = points.size() - usable.size();
    const auto first_id = uint32_t(cache.size());
    usable.resize(std::min<size_t>(usable.size(), cache.parameters().max_records - first_id));
    const Added added = add_records(cache, tracer, points, usable, frame, threads, control);
    stats.rays = added.rays, stats.duplicates = usable.size() - added.points.size();
    usable = added.points;
    stats.difference.resize(usable.size()), stats.tested.resize(usable.size());
    in_chunks(usable.size(), threads, control, [&](size_t first, size_t last) {
        for (size_t i = first; i < last; ++i) {
            const Selection s = cache.select(points[usable[i]], first_id + uint32_t(i));
            stats.tested[i] = s.tested;
            stats.difference[i] =
                s.count < 2 ? std::numeric_limits<float>::quiet_NaN() : cache.mean_difference(s);
        }
    });
    return stats;
}

}  // namespace viscache

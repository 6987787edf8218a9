#include "viscache/vismap/temporal.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "viscache/sampling/rng.h"

namespace viscache {

namespace {

float share_wrong(const RecordHead& h) { return h.rays ? float(h.misses) / float(h.rays) : 0.f; }

/// The records with the highest error rates; of equal ones the older.
std::vector<uint8_t> worst(const RecordPool& records, const MapCacheParameters& rules) {
    std::vector<uint32_t> candidates;
    for (uint32_t id = 0; id < records.size(); ++id)
        // Records with few rays prove nothing, and those without a miss are never among the worst.
        if (records.head(id).rays >= std::max(1u, rules.min_rays) && records.head(id).misses)
            candidates.push_back(id);
    const size_t k = std::min<size_t>(rules.k_worst, candidates.size());
    std::stable_sort(candidates.begin(), candidates.end(), [&](uint32_t a, uint32_t b) {
        const RecordHead &x = records.head(a), &y = records.head(b);
        // Compares misses / rays as products: exact, unlike quotients.
        return uint64_t(x.misses) * y.rays > uint64_t(y.misses) * x.rays;
    });
    std::vector<uint8_t> removed(records.size());
    for (size_t i = 0; i < k; ++i) removed[candidates[i]] = 1;
    return removed;
}

bool too_often_wrong(const RecordHead& h, const MapCacheParameters& rules) {
    // At least one ray: 0 of 0 is no rate.
    if (rules.removal == Removal::kNone || h.rays < std::max(1u, rules.min_rays)) return false;
    const bool wilson = rules.removal == Removal::kWilson;
    return (wilson ? wilson_lower(h.misses, h.rays) : share_wrong(h)) > float(rules.eps_max);
}

}  // namespace

void RecordTally::merge(const RecordTally& other) {
    for (size_t i = 0; i < rays.size(); ++i) {
        rays[i] += other.rays[i];
        misses[i] += other.misses[i];
        used[i] |= other.used[i];
    }
}

void add_tally(MapCache& cache, const RecordTally& tally, uint32_t frame) {
    RecordPool& records = cache.records();
    if (tally.rays.size() != records.size())
        throw std::invalid_argument("tally must have one entry per record, " +
                                    std::to_string(records.size()) + ", got " +
                                    std::to_string(tally.rays.size()));
    for (uint32_t id = 0; id < records.size(); ++id) {
        RecordHead& h = records.head(id);
        // The same rounding offset for both, so that misses never exceed rays
        // `up` is in [0, kRay), so n units become n / kRay rays on average.
        const uint64_t up = mix64(uint64_t(frame) << 32 | id) % RecordTally::kRay;
        uint64_t rays = h.rays + (tally.rays[id] + up) / RecordTally::kRay,
                 misses = h.misses + (tally.misses[id] + up) / RecordTally::kRay;
        // Halve both counters instead of overflowing: their ratio stays
        while (rays > 0xffffffffu) {
            rays /= 2;
            misses /= 2;
        }
        h.rays = uint32_t(rays);
        h.misses = uint32_t(misses);
        if (tally.used[id]) h.last_used = frame;
    }
}

void mark_used(MapCache& cache, std::span<const CachePoint> points, uint32_t frame, int threads,
               const Control& control) {
    constexpr size_t kPointsPerChunk = 256;
    threads = resolve_threads(threads);
    // Marks of each thread apart: threads share no bytes.
    std::vector<std::vector<uint8_t>> used(static_cast<size_t>(threads));
    parallel_for((points.size() + kPointsPerChunk - 1) / kPointsPerChunk, threads, [&](size_t chunk, int t) {
        control.check();
        std::vector<uint8_t>& own = used[size_t(t)];
        // Only for threads that get a chunk
        own.resize(cache.size());
        NeighbourList around;
        const size_t first = chunk * kPointsPerChunk;
        for (const CachePoint& p : points.subspan(first, std::min(kPointsPerChunk, points.size() - first))) {
            if (!p.usable()) continue;
            const Selection s = cache.select(p, around);
            // Blending leaves out records of weight 0, so these are not used.
            for (int i = 0; i < s.count; ++i) own[s.best[size_t(i)].id] |= s.best[size_t(i)].weight > 0;
        }
    });
    for (const std::vector<uint8_t>& own : used)
        for (uint32_t id = 0; id < own.size(); ++id)
            if (own[id]) cache.records().head(id).last_used = frame;
}

RemovalStats remove_records(MapCache& cache, uint32_t frame) {
    const MapCacheParameters& rules = cache.parameters();
    const bool by_rank = rules.removal == Removal::kWorst;
    const RecordPool& records = cache.records();
    RemovalStats stats;
    const std::vector<uint8_t> is_worst = by_rank ? worst(records, rules) : std::vector<uint8_t>{};
    std::vector<uint32_t> kept;
    for (uint32_t id = 0; id < records.size(); ++id) {
        const RecordHead& h = records.head(id);
        stats.rays += h.rays;
        stats.misses += h.misses;
        const bool wrong = by_rank ? is_worst[id] : too_often_wrong(h, rules);
        // A frame before the last use comes from frames rendered out of order; nothing is unused then.
        const bool unused =
            rules.unused_frames && frame >= h.last_used && frame - h.last_used >= rules.unused_frames;
        stats.wrong += wrong;
        stats.unused += !wrong && unused;
        if (!wrong && !unused) kept.push_back(id);
    }
    // Renumbering rebuilds the tree; without a removal, ids and tree stay.
    if (kept.size() != records.size()) cache.keep(kept);
    return stats;
}

void reset_tallies(MapCache& cache) {
    for (uint32_t id = 0; id < cache.size(); ++id)
        cache.records().head(id).rays = cache.records().head(id).misses = 0;
}

float wilson_lower(uint32_t misses, uint32_t rays) {
    // Exactly 0; below, rounding could leave a trace.
    if (!misses) return 0;
    // 97.5 % quantile of the normal distribution
    constexpr double z = 1.959963984540054;
    const double n = rays, p = misses / n;
    const double centre = p + z * z / (2 * n);
    const double spread = z * std::sqrt(p * (1 - p) / n + z * z / (4 * n * n));
    return float(std::max(0.0, (centre - spread) / (1 + z * z / n)));
}

}  // namespace viscache

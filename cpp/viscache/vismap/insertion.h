#pragma once
// Inserts new records where the existing ones are not sufficient.
#include "viscache/vismap/map_cache.h"
#include "viscache/vismap/record_tracer.h"

namespace viscache {

struct InsertionStats {
    uint64_t points = 0, unusable = 0;  ///< points given; of these, points without a surface or a normal
    uint64_t passes = 0, lookups = 0;
    uint64_t no_candidate = 0, weight = 0, difference = 0;  ///< inserted records by reason
    // Points left without a record, by their last lookup
    uint64_t suppressed = 0;  ///< maps differ too much, but an existing record is too near
    uint64_t duplicates = 0;  ///< a record with the same normal exists at the point
    uint64_t refused = 0;     ///< wanted a record when the cache was full
    uint64_t rays = 0;
    uint64_t inserted() const { return no_candidate + weight + difference; }
};

/// Inserts a record at every point for which `MapCache::judge` wants one, as mode, batch and repeat_passes of
/// the cache's parameters say. New records count as used in `frame`.
///
/// Batches are processed in the order of the points. All points of a batch are looked up in parallel, while
/// the cache does not change. The points that want a record are then visited in order. A point gets a record
/// unless an earlier one of the same round is a candidate for it; in that case it is looked up again in the
/// next round. So every decision is based on the existing records. The rays of a round are traced together.
/// Later passes look up the points that have a new record in reach.
InsertionStats insert_where_needed(MapCache& cache, const RecordTracer& tracer,
                                   std::span<const CachePoint> points, uint32_t frame, int threads,
                                   Control& control);

/// Statistics of the start-up records among each other, one entry per usable point.
struct BootstrapStatistics {
    std::vector<float>
        difference;  ///< δ̄ of the maps that would be blended without the own record; NaN for less than two
    std::vector<float> tested;  ///< largest weight of another record
    uint64_t unusable = 0, duplicates = 0, rays = 0;
};
/// Inserts a record at every usable point, unless one exists there already.
BootstrapStatistics bootstrap(MapCache& cache, const RecordTracer& tracer, std::span<const CachePoint> points,
                              uint32_t frame, int threads, Control& control);

}  // namespace viscache

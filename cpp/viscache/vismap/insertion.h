#pragma once
// New records where the old ones say too little.
#include "viscache/vismap/map_cache.h"
#include "viscache/vismap/record_tracer.h"

namespace viscache {

enum class InsertionMode {
    kBatch,   ///< the same records for any number of threads
    kLocked,  ///< the paper's: threads take points as they come and share the tree by a lock
};

struct InsertionOptions {
    InsertionMode mode = InsertionMode::kBatch;
    size_t batch = 4096;  ///< points that are looked up together
    bool settle = true;   ///< pass over the points again until none wants a record
    uint32_t frame = 0;   ///< new records count as used in it
    int threads = 0;
};

struct InsertionStats {
    uint64_t points = 0, unusable = 0;  ///< given; of these, without a surface or a normal
    uint64_t passes = 0, lookups = 0;
    uint64_t no_candidate = 0, weight = 0, difference = 0;  ///< inserted, by reason
    // Points that stay without, by their last look-up
    uint64_t suppressed = 0;  ///< maps differ too much, but a record is too near for another
    uint64_t duplicates = 0;  ///< a record with the same normal stands at the point
    uint64_t refused = 0;     ///< wanted a record when the cache was full
    uint64_t rays = 0;
    uint64_t inserted() const { return no_candidate + weight + difference; }
};

/// Gives a record to every point that `MapCache::judge` says wants one.
///
/// Batches go in the order of the points. In a batch all points are looked up in parallel, the cache standing
/// still. Of those that want a record, in their order, each gets one unless an earlier one of the same round
/// is a candidate for it; the others are looked up again in the next round, so that every insertion is
/// decided on the records that stand. The rays of a round are traced together. Later passes look up the
/// points that got a new record into their reach.
InsertionStats insert_where_needed(MapCache& cache, const RecordTracer& tracer,
                                   std::span<const CachePoint> points, const InsertionOptions& options,
                                   Control& control);

/// What the start-up records say about each other, one entry per usable point.
struct BootstrapStatistics {
    std::vector<float>
        difference;             ///< δ̄ of what would be blended without the own record; NaN of less than two
    std::vector<float> tested;  ///< greatest weight of another record
    uint64_t unusable = 0, duplicates = 0, rays = 0;
};
/// A record at every usable point, unless one stands there already.
BootstrapStatistics bootstrap(MapCache& cache, const RecordTracer& tracer, std::span<const CachePoint> points,
                              uint32_t frame, int threads, Control& control);

}  // namespace viscache

#pragma once
// Maintenance of records over the frames of an animation: removes records that are often wrong or no longer
// used.
#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "viscache/math/parallel.h"
#include "viscache/vismap/map_cache.h"

namespace viscache {

/// Statistics about the records from one thread or one frame. Integer sums, so their order does not matter.
/// A ray sampled with D times the density of product sampling has the weight 1/D, so that error rates are
/// those under product sampling for any density. Weights are in units of 1/kRay.
struct RecordTally {
    static constexpr uint64_t kRay = 1 << 16;

    std::vector<uint64_t> rays,
        misses;                 ///< per record: comparisons with exact rays, and how many of them disagreed
    std::vector<uint8_t> used;  ///< per record: 1 if it was used at a point

    explicit RecordTally(size_t records = 0) : rays(records), misses(records), used(records) {}
    /// Weight of a ray.
    // The limit keeps sums below 2^64 for millions of rays.
    static uint64_t weight(double d) { return uint64_t(std::min(double(kRay) / d + 0.5, 0x1p40)); }
    /// A record of a blend gave `bit`; the exact ray gave `visible`.
    void compare(uint32_t id, bool bit, bool visible, uint64_t weight = kRay) {
        rays[id] += weight;
        misses[id] += bit != visible ? weight : 0;
    }
    void merge(const RecordTally& other);
};

/// Adds the tally of a frame, with one entry per record of the cache, to the records. Their counters are
/// integers: fractions are rounded up or down by a hash of the record and the frame, unbiased on average.
void add_tally(MapCache& cache, const RecordTally& tally, uint32_t frame);

/// Marks every record that is blended at one of the points as used in the frame.
void mark_used(MapCache& cache, std::span<const CachePoint> points, uint32_t frame, int threads,
               const Control& control);

struct RemovalStats {
    uint64_t wrong = 0, unused = 0;  ///< removed records by reason
    uint64_t rays = 0, misses = 0;   ///< over all records before the removal
};
/// Ends a frame: removes records as the cache's parameters say. The remaining records are renumbered in
/// order.
RemovalStats remove_records(MapCache& cache, uint32_t frame);

/// Resets rays and misses, as after a change of the geometry.
void reset_tallies(MapCache& cache);

/// Lower end of Wilson's 95 % interval of a proportion.
float wilson_lower(uint32_t misses, uint32_t rays);

}  // namespace viscache

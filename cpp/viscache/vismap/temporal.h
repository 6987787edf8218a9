#pragma once
// Records over the frames of an animation: who is often wrong or no longer used has to go.
#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "viscache/math/parallel.h"
#include "viscache/vismap/map_cache.h"

namespace viscache {

/// What one thread, or one frame, learnt about the records; sums of integers, so their order does not matter.
/// A ray counts 1/D where it was drawn by a density D times that of product sampling, so that shares of wrong
/// answers are those under product sampling whatever the density; in units of 1/kRay.
struct RecordTally {
    static constexpr uint64_t kRay = 1 << 16;

    std::vector<uint64_t> rays,
        misses;                 ///< per record: exact rays it was compared with, and where it was wrong
    std::vector<uint8_t> used;  ///< per record: 1 if it spoke for a point

    explicit RecordTally(size_t records = 0) : rays(records), misses(records), used(records) {}
    /// What a ray counts.
    static uint64_t weight(double d) { return uint64_t(std::min(double(kRay) / d + 0.5, 0x1p40)); }
    /// A record of a blend said `bit` where an exact ray said `visible`.
    void compare(uint32_t id, bool bit, bool visible, uint64_t weight = kRay) {
        rays[id] += weight, misses[id] += bit != visible ? weight : 0;
    }
    void merge(const RecordTally& other);
};

/// Adds a frame's tally to the records; one per record of the cache. Counters are whole: fractions go up or
/// down by the record's and the frame's number, right on average.
void add_tally(MapCache& cache, const RecordTally& tally, uint32_t frame);

/// Every record that is blended at one of the points counts as used in the frame.
void mark_used(MapCache& cache, std::span<const CachePoint> points, uint32_t frame, int threads,
               const Control& control);

struct RemovalRules {
    float eps_max = 0.05f;        ///< share of wrong answers above which a record goes
    uint32_t min_rays = 64;       ///< before this many rays no record goes for its errors
    bool wilson = false;          ///< hold the lower end of the share's 95 % interval against eps_max instead
    uint32_t k_worst = 0;         ///< > 0: remove this many with the highest shares instead
    uint32_t unused_frames = 10;  ///< frames without use after which a record goes; 0 = never
};

struct RemovalStats {
    uint64_t wrong = 0, unused = 0;  ///< removed, by reason
    uint64_t rays = 0, misses = 0;   ///< of all records before the removal
};
/// The end of a frame. The records that stay are numbered anew in their order.
RemovalStats remove_records(MapCache& cache, const RemovalRules& rules, uint32_t frame);

/// Forgets rays and misses, as after a change of the geometry.
void reset_tallies(MapCache& cache);

/// Lower end of Wilson's 95 % interval of a share.
float wilson_lower(uint32_t misses, uint32_t rays);

}  // namespace viscache

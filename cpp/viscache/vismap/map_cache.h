#pragma once
// The records of a scene, and the approximate visibility they give at a point.
#include <array>
#include <shared_mutex>

#include "viscache/vismap/blended_maps.h"
#include "viscache/vismap/map_difference.h"
#include "viscache/vismap/map_parameters.h"
#include "viscache/vismap/neighbour_list.h"
#include "viscache/vismap/record_pool.h"
#include "viscache/vismap/weights.h"

namespace viscache {

constexpr uint32_t kNoRecord = 0xffffffffu;

/// A point of a lookup. d_max and the footprint come from the projected area of the pixel.
struct CachePoint {
    Vec3 position, normal;
    float d_max = 0;      ///< search radius for records; 0: nothing was hit here
    float footprint = 0;  ///< square root of the area of the pixel projected onto the surface

    bool usable() const { return d_max > 0; }
};

/// Result of a lookup.
struct Selection {
    struct Chosen {
        uint32_t id;
        float weight;  ///< w_g·ŵ
    };
    std::array<Chosen, kMaxBlended> best;  ///< in descending order of weight
    int count = 0;
    int candidates = 0;         ///< records in reach with similar normals, at most m_nearest
    float tested = 0;           ///< largest of the weights compared with w_min
    float nearest = kInfinity;  ///< distance of the nearest candidate
};

/// Whether a point gets a record, and why.
enum class Verdict { kServed, kSuppressed, kDuplicate, kNoCandidate, kWeight, kDifference };
inline bool wants_record(Verdict v) { return v >= Verdict::kNoCandidate; }

class MapCache {
public:
    explicit MapCache(const MapCacheParameters& parameters);

    const MapCacheParameters& parameters() const { return parameters_; }
    /// Replaces the thresholds of the parameters. The thresholds are 0.3 and 0.06 where neither says them.
    void set_thresholds(double w_min, double delta_max);
    /// The direction of every cell, in Z order (record_pattern).
    std::span<const Vec3> pattern() const { return pattern_; }
    const RecordPool& records() const { return records_; }
    RecordPool& records() { return records_; }
    const KdTree& tree() const { return tree_; }
    size_t size() const { return records_.size(); }
    bool full() const { return size() >= parameters_.max_records; }

    /// The records in reach with similar normals, nearest first. `around` speeds up searches at nearby
    /// points.
    std::span<const NearestSet::Found> candidates(const CachePoint& point, NearestSet& set,
                                                  NeighbourList& around) const;
    /// The best candidates by weight, except the record `without`.
    Selection select(const CachePoint& point, NeighbourList& around, uint32_t without = kNoRecord) const;
    /// δ̄: the mean of Eq. 11 over all pairs of the selected records; 0 for less than two.
    float mean_difference(const Selection& s) const;
    /// The insertion test.
    Verdict judge(const CachePoint& point, const Selection& s) const;
    /// [VisMap Eq. 8] The maps used at a point, with weights β normalised to a sum of one. Empty if no
    /// record is in reach or all weights are zero.
    BlendedMaps blend(const Selection& s) const;

    /// True if a record with the same normal exists at the point, within 1e-6 of d_max and of unit length.
    bool has_duplicate(const CachePoint& point) const;
    /// Adds a record; returns its id.
    uint32_t add(const RecordHead& head, const Word* bits, const AmbientRecord& ambient);
    /// Keeps only these records and renumbers them in order; the ids increase.
    void keep(const std::vector<uint32_t>& ids);

    /// For concurrent lookups and insertions: readers share the lock, `add` needs it exclusively.
    std::shared_mutex& mutex() const { return mutex_; }

private:
    float tested_weight(const NearestSet::Found& f, float raw, float normalized, float full) const;

    MapCacheParameters parameters_;
    std::vector<Vec3> pattern_;
    RecordPool records_;
    KdTree tree_;
    NormalizedWeight normalized_;
    float cos_theta_max_, w_min_, delta_max_;
    CountDifferences count_differences_;
    mutable std::shared_mutex mutex_;
};

}  // namespace viscache

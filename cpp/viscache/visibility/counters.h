#pragma once
// Counters of a frame. Each work item has its own object; they are merged in a fixed order.
#include <array>
#include <cstdint>

namespace viscache {

constexpr int kLightGroups = 8;
/// Light groups of a frame, always in this order. The last two belong to bidirectional path tracing:
/// connections between two surfaces, and between a surface and the camera.
enum class LightGroup : int {
    kPoint,
    kDirectional,
    kArea,
    kEnvironment,
    kVpl,
    kAmbient,
    kConnection,
    kCamera
};
constexpr const char* kLightGroupNames[kLightGroups] = {"point", "directional", "area",       "environment",
                                                        "vpl",   "ambient",     "connection", "camera"};
constexpr int kMaxLevels = 32;

/// Classes of answers by what tells how often they are wrong: 4 if the oracle doubts the answer, + 2 if it is
/// "visible", + 1 if a neighbouring light has the other answer.
constexpr size_t kAnswerClasses = 8;
/// Queries of a class; those whose ray was traced as well; of these, those whose answer the ray contradicts.
struct ClassCounters {
    uint64_t queries = 0, checked = 0, wrong = 0;
};

struct GroupCounters {
    uint64_t queries = 0;   ///< visibility tests requested by the renderer
    uint64_t occluded = 0;  ///< of these, answered "blocked"
    uint64_t rays = 0;      ///< shadow rays traced for them
};

struct Counters {
    std::array<GroupCounters, kLightGroups> groups;
    uint64_t camera_rays = 0;    ///< rays of eye paths, including mirror and glass branches
    uint64_t light_rays = 0;     ///< rays of VPL tracing and of resampling
    double lost_throughput = 0;  ///< throughput of eye paths that were cut off: at max_depth, or refracted to
                                 ///< the wrong side of the surface; a sum over the eye samples
    // Quantized cache
    std::array<uint64_t, kMaxLevels> rays_per_level{};
    uint64_t leftover_rays = 0;      ///< waves: bits active for a pixel but not for its representative
    uint64_t lookups = 0, hits = 0;  ///< lookups of single bits in tables or rows, without neighbour probes
    uint64_t neighbour_probes = 0, nil_neighbours = 0;
    uint64_t evictions = 0;     ///< writes that replace another key
    uint64_t bypassed = 0;      ///< queries traced without the cache (non-finite input, degenerate normal)
    uint64_t clamped_low = 0;   ///< R < 1
    uint64_t clamped_high = 0;  ///< R > R_max
    uint64_t clamped_nan = 0;   ///< R is NaN: finest resolution
    uint64_t boundary_queries = 0;               ///< cell disagrees with a neighbour at the last level tested
    uint64_t cells = 0;                          ///< number of eye cells
    uint64_t table_writes = 0, table_slots = 0;  ///< hash form: expected occupancy 1 − exp(−writes/slots)
    uint64_t table_occupied = 0;  ///< occupied slots at the end, for a table shared by the whole frame
    uint64_t duplicates = 0;      ///< rays for a cluster that another thread or work item also traced
    double expected_false_hits = 0;
    // A table kept between frames: answers reused without a new ray, by the frame that traced the bit; of
    // these, answers that were also traced, and those that the ray contradicted
    uint64_t reused_kept = 0, reused_fresh = 0, checked_kept = 0, checked_fresh = 0, wrong_kept = 0,
             wrong_fresh = 0;
    // Answers as control variates
    uint64_t corrections = 0;    ///< queries whose ray was traced as well
    uint64_t wrong = 0;          ///< of these, those whose answer the ray contradicts
    uint64_t exact_queries = 0;  ///< queries that are never corrected, as exact rays answer them
    /// The same by light group and class, for lights that all eye points share
    std::array<std::array<ClassCounters, kAnswerClasses>, kLightGroups> classes{};
    // Product sampling of the environment
    uint64_t product_points = 0, product_dark = 0;  ///< eye points; of these, without light or reflection
    uint64_t product_guided = 0,
             product_without_record = 0;  ///< of these, with a guided density; without a record
    uint64_t pilot_rays = 0;              ///< rays of the pilot before the first pass
    double greatest_ratio = 0;            ///< maximum of B/B̃ over all samples
    uint64_t non_finite = 0;              ///< contributions dropped because they were not finite
    // Blocks of shared directions for which an engine was chosen
    uint64_t direction_rays = 0, batch_rays = 0;  ///< all rays; those traced by the aligned batch
    double batch_ns = 0, embree_ns = 0;           ///< predicted costs, summed over `predicted_rays`
    uint64_t predicted_rays = 0;

    uint64_t queries() const {
        uint64_t n = 0;
        for (auto& g : groups) n += g.queries;
        return n;
    }
    uint64_t rays() const {
        uint64_t n = 0;
        for (auto& g : groups) n += g.rays;
        return n;
    }
    GroupCounters& group(int i) { return groups[size_t(i)]; }
    /// Adds counts of writes to a table.
    void add_writes(uint64_t writes, uint64_t evicted, uint64_t twice, double false_hits) {
        table_writes += writes;
        evictions += evicted;
        duplicates += twice;
        expected_false_hits += false_hits;
    }
    void merge(const Counters& b);
};

inline void Counters::merge(const Counters& b) {
    for (int i = 0; i < kLightGroups; ++i) {
        groups[i].queries += b.groups[i].queries;
        groups[i].occluded += b.groups[i].occluded;
        groups[i].rays += b.groups[i].rays;
    }
    for (int i = 0; i < kMaxLevels; ++i) rays_per_level[i] += b.rays_per_level[i];
    camera_rays += b.camera_rays;
    light_rays += b.light_rays;
    lost_throughput += b.lost_throughput;
    leftover_rays += b.leftover_rays;
    lookups += b.lookups;
    hits += b.hits;
    neighbour_probes += b.neighbour_probes;
    nil_neighbours += b.nil_neighbours;
    evictions += b.evictions;
    bypassed += b.bypassed;
    clamped_low += b.clamped_low;
    clamped_high += b.clamped_high;
    clamped_nan += b.clamped_nan;
    boundary_queries += b.boundary_queries;
    cells += b.cells;
    table_writes += b.table_writes;
    table_slots += b.table_slots;
    table_occupied += b.table_occupied;
    duplicates += b.duplicates;
    expected_false_hits += b.expected_false_hits;
    non_finite += b.non_finite;
    reused_kept += b.reused_kept;
    reused_fresh += b.reused_fresh;
    checked_kept += b.checked_kept;
    checked_fresh += b.checked_fresh;
    wrong_kept += b.wrong_kept;
    wrong_fresh += b.wrong_fresh;
    corrections += b.corrections;
    wrong += b.wrong;
    exact_queries += b.exact_queries;
    for (size_t g = 0; g < classes.size(); ++g)
        for (size_t k = 0; k < kAnswerClasses; ++k) {
            classes[g][k].queries += b.classes[g][k].queries;
            classes[g][k].checked += b.classes[g][k].checked;
            classes[g][k].wrong += b.classes[g][k].wrong;
        }
    product_points += b.product_points;
    product_dark += b.product_dark;
    product_guided += b.product_guided;
    product_without_record += b.product_without_record;
    pilot_rays += b.pilot_rays;
    direction_rays += b.direction_rays;
    batch_rays += b.batch_rays;
    batch_ns += b.batch_ns;
    embree_ns += b.embree_ns;
    predicted_rays += b.predicted_rays;
    greatest_ratio = greatest_ratio > b.greatest_ratio ? greatest_ratio : b.greatest_ratio;
}

}  // namespace viscache

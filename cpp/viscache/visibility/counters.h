#pragma once
// Counters of a frame, one row each. Each work item has its own object; they are merged in a fixed order.
// `merge`, frame_dict and `help(vc.Frame)` read the rows.
#include <algorithm>
#include <array>
#include <cstdint>
#include <tuple>
#include <type_traits>

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
    void operator+=(const ClassCounters& b) {
        queries += b.queries;
        checked += b.checked;
        wrong += b.wrong;
    }
};

/// Visibility tests requested by the renderer; of these, answered "blocked"; shadow rays traced for them.
struct GroupCounters {
    uint64_t queries = 0, occluded = 0, rays = 0;
    void operator+=(const GroupCounters& b) {
        queries += b.queries;
        occluded += b.occluded;
        rays += b.rays;
    }
};

/// What each counts, and how two are merged: kCounterRows.
struct Counters {
    std::array<GroupCounters, kLightGroups> groups;
    uint64_t camera_rays = 0, light_rays = 0;
    double lost_throughput = 0;
    // Quantized cache
    std::array<uint64_t, kMaxLevels> rays_per_level{};
    uint64_t leftover_rays = 0, lookups = 0, hits = 0, neighbour_probes = 0, nil_neighbours = 0;
    uint64_t evictions = 0, bypassed = 0, clamped_low = 0, clamped_high = 0, clamped_nan = 0;
    uint64_t boundary_queries = 0, cells = 0, table_writes = 0, table_slots = 0, table_occupied = 0;
    uint64_t duplicates = 0;
    double expected_false_hits = 0;
    // A table kept between frames
    uint64_t reused_kept = 0, reused_fresh = 0, checked_kept = 0, checked_fresh = 0, wrong_kept = 0,
             wrong_fresh = 0;
    // Answers as control variates
    uint64_t corrections = 0, wrong = 0, exact_queries = 0;
    std::array<std::array<ClassCounters, kAnswerClasses>, kLightGroups> classes{};
    // Product sampling of the environment
    uint64_t product_points = 0, product_dark = 0, product_guided = 0, product_without_record = 0,
             pilot_rays = 0;
    double greatest_ratio = 0;
    uint64_t non_finite = 0;
    // Blocks of shared directions for which an engine was chosen
    uint64_t direction_rays = 0, batch_rays = 0, predicted_rays = 0;
    double batch_ns = 0, embree_ns = 0;

    uint64_t queries() const { return sum(&GroupCounters::queries); }
    uint64_t occluded() const { return sum(&GroupCounters::occluded); }
    uint64_t rays() const { return sum(&GroupCounters::rays); }
    GroupCounters& group(int i) { return groups[size_t(i)]; }
    /// Adds counts of writes to a table.
    void add_writes(uint64_t writes, uint64_t evicted, uint64_t twice, double false_hits) {
        table_writes += writes;
        evictions += evicted;
        duplicates += twice;
        expected_false_hits += false_hits;
    }
    void merge(const Counters& b);

private:
    uint64_t sum(uint64_t GroupCounters::* count) const {
        uint64_t n = 0;
        for (const GroupCounters& g : groups) n += g.*count;
        return n;
    }
};

/// When `Frame.counters` has a counter: always; with product sampling; with one table for the frame; or as
/// frame_dict and the sources of oracles write it.
enum class Shown { kAlways, kProduct, kFrameTable, kElsewhere };
enum class Merge { kSum, kMost };

template <class Value>
struct CounterRow {
    const char* name;
    Value Counters::* member;
    const char* doc;
    Shown shown;
    Merge merge;
};
template <class Value>
constexpr CounterRow<Value> counter(const char* name, Value Counters::* member, const char* doc,
                                    Shown shown = Shown::kAlways, Merge merge = Merge::kSum) {
    return {name, member, doc, shown, merge};
}

// clang-format off
inline constexpr std::tuple kCounterRows{
    counter("groups", &Counters::groups,
        "By light group: queries, those answered \"blocked\", and rays.", Shown::kElsewhere),
    counter("camera_rays", &Counters::camera_rays,
        "Rays of eye paths, including mirror and glass branches."),
    counter("light_rays", &Counters::light_rays,
        "Rays that trace and resample virtual point lights."),
    counter("lost_throughput", &Counters::lost_throughput,
        "Mean throughput of an eye sample that was cut off: at max_depth, or refracted to the wrong side of "
        "the surface.", Shown::kElsewhere),
    counter("rays_per_level", &Counters::rays_per_level,
        "Rays of the quantized cache by level, coarse to fine.", Shown::kElsewhere),
    counter("leftover_rays", &Counters::leftover_rays,
        "Waves: rays for queries whose cell's representative does not ask for that light."),
    counter("lookups", &Counters::lookups,
        "Look-ups of single bits in tables or rows, without neighbour probes."),
    counter("hits", &Counters::hits, "Look-ups that found a bit."),
    counter("neighbour_probes", &Counters::neighbour_probes,
        "Look-ups in neighbouring cells, by query; in waves by cell."),
    counter("nil_neighbours", &Counters::nil_neighbours, "Of these, those that found nothing."),
    counter("evictions", &Counters::evictions, "Writes that replaced another key."),
    counter("bypassed", &Counters::bypassed,
        "Queries that were traced without the cache: non-finite input, a degenerate normal."),
    counter("clamped_low", &Counters::clamped_low, "Resolutions below 1."),
    counter("clamped_high", &Counters::clamped_high, "Resolutions above the ladder."),
    counter("clamped_nan", &Counters::clamped_nan, "Resolutions that are no number: the finest is used."),
    counter("boundary_queries", &Counters::boundary_queries,
        "Queries whose cell disagrees with a neighbour at the last level tested."),
    counter("cells", &Counters::cells, "Eye cells."),
    counter("table_writes", &Counters::table_writes, "Bits written to tables."),
    counter("table_slots", &Counters::table_slots,
        "Slots of these tables; the expected occupancy is 1 - exp(-writes/slots)."),
    counter("table_occupied", &Counters::table_occupied,
        "Occupied slots of a table of the whole frame at its end.", Shown::kFrameTable),
    counter("duplicates", &Counters::duplicates,
        "Rays for a cluster that another thread or work item also traced.", Shown::kFrameTable),
    counter("expected_false_hits", &Counters::expected_false_hits,
        "Expected number of hits of another key's bit."),
    counter("non_finite", &Counters::non_finite, "Contributions that were dropped because they were not finite."),
    counter("reused_kept", &Counters::reused_kept,
        "Answers from a kept table whose bit an earlier frame traced.", Shown::kElsewhere),
    counter("reused_fresh", &Counters::reused_fresh, "The same, traced by this frame.", Shown::kElsewhere),
    counter("checked_kept", &Counters::checked_kept, "Of reused_kept, those also traced.", Shown::kElsewhere),
    counter("checked_fresh", &Counters::checked_fresh, "Of reused_fresh, those also traced.", Shown::kElsewhere),
    counter("wrong_kept", &Counters::wrong_kept, "Of checked_kept, those that the ray contradicts.",
        Shown::kElsewhere),
    counter("wrong_fresh", &Counters::wrong_fresh, "Of checked_fresh, those that the ray contradicts.",
        Shown::kElsewhere),
    counter("corrections", &Counters::corrections,
        "With use=\"correct\": answers whose ray was traced as well.", Shown::kElsewhere),
    counter("wrong", &Counters::wrong, "Of corrections, those that the ray contradicts.", Shown::kElsewhere),
    counter("exact_queries", &Counters::exact_queries,
        "Queries that are never corrected, because exact rays answer them.", Shown::kElsewhere),
    counter("share_by_class", &Counters::classes,
        "Queries, corrections and wrong answers by light group and class of answers, for lights that all eye "
        "points share.", Shown::kElsewhere),
    counter("product_points", &Counters::product_points, "Eye points with product sampling of the environment.",
        Shown::kProduct),
    counter("product_dark", &Counters::product_dark, "Of these, without light or reflection.", Shown::kProduct),
    counter("product_guided", &Counters::product_guided, "With a guided density.", Shown::kProduct),
    counter("product_without_record", &Counters::product_without_record, "Without a record of the maps.",
        Shown::kProduct),
    counter("greatest_ratio", &Counters::greatest_ratio,
        "Largest ratio of reflected light to its estimate B̃ over all samples.", Shown::kProduct, Merge::kMost),
    counter("pilot_rays", &Counters::pilot_rays, "Rays of the pilot before the first pass.", Shown::kProduct),
    counter("direction_rays", &Counters::direction_rays,
        "Rays along shared directions for which an engine was chosen.", Shown::kElsewhere),
    counter("batch_rays", &Counters::batch_rays, "Of these, those of the aligned batch.", Shown::kElsewhere),
    counter("predicted_rays", &Counters::predicted_rays, "Of these, those with a prediction.", Shown::kElsewhere),
    counter("batch_ns", &Counters::batch_ns, "Predicted cost of a ray of the batch.", Shown::kElsewhere),
    counter("embree_ns", &Counters::embree_ns, "Predicted cost of a ray of Embree.", Shown::kElsewhere),
};
// clang-format on

/// Calls `visit` with every row.
template <class Visit>
constexpr void for_each_counter(Visit visit) {
    std::apply([&](const auto&... rows) { (visit(rows), ...); }, kCounterRows);
}

namespace detail {
template <class Value>
void add_counts(Value& a, const Value& b) {
    if constexpr (requires { a += b; })
        a += b;
    else
        for (size_t i = 0; i < a.size(); ++i) add_counts(a[i], b[i]);
}
}  // namespace detail

inline void Counters::merge(const Counters& b) {
    for_each_counter([&]<class Value>(const CounterRow<Value>& row) {
        Value& mine = this->*row.member;
        const Value& other = b.*row.member;
        if constexpr (std::is_arithmetic_v<Value>)
            if (row.merge == Merge::kMost) {
                mine = std::max(mine, other);
                return;
            }
        detail::add_counts(mine, other);
    });
}

}  // namespace viscache

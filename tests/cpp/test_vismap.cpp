// vismap: insertion on several threads, with a lock and in batches.
#include <cmath>

#include "check.h"
#include "viscache/vismap/insertion.h"
#include "viscache/vismap/temporal.h"

namespace viscache::test::vismap_tests {
namespace {

/// A ball above the plane y = 0.
class Ball final : public RayCaster {
public:
    void intersect(std::span<const Ray> rays, std::span<Hit> hits, Coherence) const override {
        for (size_t i = 0; i < rays.size(); ++i) {
            hits[i] = {};
            if (const float t = distance(rays[i].o, rays[i].d); t > 0) {
                hits[i].t = t;
                hits[i].mesh = 0;
            }
        }
    }
    void occluded(std::span<const Ray> rays, std::span<uint8_t> occluded) const override {
        for (size_t i = 0; i < rays.size(); ++i) occluded[i] = distance(rays[i].o, rays[i].d) > 0;
    }
    uint16_t occluded16(uint16_t mask, RayPacket16& r, Coherence) const override {
        unsigned hit = 0;
        for (int i = 0; i < 16; ++i)
            hit |= unsigned(distance({r.ox[i], r.oy[i], r.oz[i]}, {r.dx[i], r.dy[i], r.dz[i]}) > 0) << i;
        return uint16_t(hit & mask);
    }

private:
    /// Distance to the ball along a unit direction; 0 for a miss.
    static float distance(Vec3 origin, Vec3 direction) {
        const Vec3 to = Vec3{0, 0.4f, 0} - origin;
        const float along = dot(to, direction), inside = along * along - length2(to) + 0.09f;
        return along > 0 && inside > 0 ? along - std::sqrt(inside) : 0.f;
    }
};

/// 60 × 60 points of the plane.
std::vector<CachePoint> points() {
    std::vector<CachePoint> all;
    for (int y = 0; y < 60; ++y)
        for (int x = 0; x < 60; ++x)
            all.push_back({{float(x) / 30 - 1, 0, float(y) / 30 - 1}, {0, 1, 0}, 0.3f, 1.f / 30});
    return all;
}

MapCache cache_of(Criterion criterion, InsertionMode mode = InsertionMode::kBatch) {
    return MapCache(
        {.m = 4, .w_min = 0.6f, .delta_max = 0.02f, .criterion = criterion, .mode = mode, .batch = 500});
}

InsertionStats filled(MapCache& cache, int threads) {
    const Ball ball;
    const RecordTracer tracer(ball, 2, cache.pattern(), cache.parameters().criterion == Criterion::kAmbient);
    Control control;
    return insert_where_needed(cache, tracer, points(), 0, threads, control);
}

void all_records_are_found_and_no_point_wants_more(MapCache& cache, const std::string& what) {
    for (uint32_t id = 0; id < cache.size(); ++id) {
        const RecordHead& h = cache.records().head(id);
        check(cache.has_duplicate({h.position, h.normal, 0.3f, 0}), what + ": a record is found where it is");
    }
    size_t wanting = 0;
    NeighbourList around;
    for (const CachePoint& p : points()) wanting += wants_record(cache.judge(p, cache.select(p, around)));
    check_equal(wanting, size_t{0}, what + ": points that need a record");
}

void threads_under_a_lock_serve_every_point() {
    for (Criterion criterion : {Criterion::kVisibility, Criterion::kAmbient}) {
        MapCache cache = cache_of(criterion, InsertionMode::kLocked);
        const InsertionStats stats = filled(cache, 4);
        check(cache.size() > 50, "locked: there are records");
        check_equal(uint64_t(cache.size()), stats.inserted(), "locked: records");
        all_records_are_found_and_no_point_wants_more(cache, "locked");
    }
}

void batches_give_the_same_records_on_any_number_of_threads() {
    MapCache one = cache_of(Criterion::kVisibility), four = cache_of(Criterion::kVisibility);
    filled(one, 1);
    filled(four, 4);
    check_equal(four.size(), one.size(), "batch: records");
    for (uint32_t id = 0; id < std::min(one.size(), four.size()); ++id) {
        check(one.records().head(id).position == four.records().head(id).position, "batch: position");
        check(std::equal(one.records().bits(id), one.records().bits(id) + map_words(4),
                         four.records().bits(id)),
              "batch: map");
    }
    all_records_are_found_and_no_point_wants_more(four, "batch");
}

void blended_maps_outlive_later_insertions() {
    MapCache cache = cache_of(Criterion::kVisibility);
    const std::vector<Word> map(map_words(4), 0x00ff00ff00ff00ffull);
    cache.add({{0, 0, 0}, {0, 1, 0}}, map.data(), {});
    NeighbourList around;
    const BlendedMaps maps = cache.blend(cache.select({{0.01f, 0, 0}, {0, 1, 0}, 0.3f, 0}, around));
    check_equal(maps.count, 1, "records blended");
    for (int i = 1; i < 2000; ++i) {
        const std::vector<Word> other(map_words(4), Word(i));
        cache.add({{float(i), 0, 0}, {0, 1, 0}}, other.data(), {});
    }
    check(std::equal(map.begin(), map.end(), maps.bits[0]), "a blended map stays where it is");
}

void uses_are_marked_on_threads_and_the_rest_removed() {
    MapCache cache = cache_of(Criterion::kVisibility);
    filled(cache, 2);
    const Control control;
    std::vector<CachePoint> some = points();
    some.resize(600);
    mark_used(cache, some, 10, 4, control);
    const size_t before = cache.size();
    const RemovalStats stats = remove_records(cache, 10);
    check(stats.unused > 0 && cache.size() > 0, "unused records go, used ones stay");
    check_equal(cache.size() + stats.unused, before, "records before and after");
}

void fractions_of_rays_are_right_on_average() {
    MapCache cache = cache_of(Criterion::kVisibility);
    const std::vector<Word> map(map_words(4), 0);
    constexpr uint32_t n = 4000;
    for (uint32_t i = 0; i < n; ++i) cache.add({{float(i), 0, 0}, {0, 1, 0}}, map.data(), {});
    RecordTally tally(n);
    // D = 4 counts 0.25 rays and D = 0.3 counts 1/0.3; of their sum, 0.25 are misses
    for (uint32_t i = 0; i < n; ++i) {
        tally.compare(i, false, true, RecordTally::weight(4));
        tally.compare(i, false, false, RecordTally::weight(0.3));
    }
    add_tally(cache, tally, 7);
    uint64_t rays = 0, misses = 0;
    for (uint32_t i = 0; i < n; ++i) {
        const RecordHead& h = cache.records().head(i);
        check(h.misses <= 1 && (h.rays == 3 || h.rays == 4) && h.misses <= h.rays, "next whole numbers");
        rays += h.rays;
        misses += h.misses;
    }
    check(std::abs(double(rays) / n - (0.25 + 1 / 0.3)) < 0.03, "rays on average");
    check(std::abs(double(misses) / n - 0.25) < 0.03, "misses on average");
    check_equal(RecordTally::weight(1), RecordTally::kRay, "product sampling counts whole rays");
}

const Suite suite{
    {"vismap: fractions of rays are right on average", fractions_of_rays_are_right_on_average},
    {"vismap: threads under a lock serve every point", threads_under_a_lock_serve_every_point},
    {"vismap: batches give the same records on any number of threads",
     batches_give_the_same_records_on_any_number_of_threads},
    {"vismap: blended maps outlive later insertions", blended_maps_outlive_later_insertions},
    {"vismap: uses are marked on threads and the rest removed",
     uses_are_marked_on_threads_and_the_rest_removed},
};

}  // namespace
}  // namespace viscache::test::vismap_tests

#include "viscache/vismap/map_cache.h"

#include "viscache/vismap/record_tracer.h"

namespace viscache {

namespace {

constexpr float kLeastWeightSum = 1e-12f;
constexpr double kWMin = 0.3, kDeltaMax = 0.06;  // where nothing else is said

}  // namespace

MapCache::MapCache(const MapCacheParameters& parameters)
    : parameters_((parameters.validate(), parameters)),
      pattern_(record_pattern(parameters.m, parameters.seed)),
      records_(parameters.m),
      normalized_(parameters.theta_max_rad(), float(parameters.lambda)),
      cos_theta_max_(std::cos(parameters.theta_max_rad())),
      count_differences_(count_differences(active_isa())) {
    set_thresholds(parameters.w_min < 0 ? kWMin : parameters.w_min,
                   parameters.delta_max < 0 ? kDeltaMax : parameters.delta_max);
}

void MapCache::set_thresholds(double w_min, double delta_max) {
    MapCacheParameters changed = parameters_;
    changed.w_min = w_min;
    changed.delta_max = delta_max;
    changed.validate();
    w_min_ = float(w_min);
    delta_max_ = float(delta_max);
}

std::span<const NearestSet::Found> MapCache::candidates(const CachePoint& point, NearestSet& set,
                                                        NeighbourList& around) const {
    // Cosines are compared, without an arc cosine per record.
    const auto similar = [&](Vec3 normal) { return dot(point.normal, normal) > cos_theta_max_; };
    if (parameters_.filter == SearchFilter::kDuring) {
        around.search(tree_, point.position, [&](const TreePoint& p) { return similar(p.normal); }, set);
        return set.sorted();
    }
    // Differs (M32): Fig. 6 shows the test of normals after the search; the text of Sec. 5.1 makes it part of
    // the search
    around.search(tree_, point.position, [](const TreePoint&) { return true; }, set);
    return set.sorted_without([&](const NearestSet::Found& f) { return !similar(f.point->normal); });
}

float MapCache::tested_weight(const NearestSet::Found& f, float raw, float normalized, float full) const {
    const float weight = parameters_.weight_test == WeightTest::kFull         ? full
                         : parameters_.weight_test == WeightTest::kNormalized ? normalized
                                                                              : raw;
    if (parameters_.criterion == Criterion::kVisibility) return weight;
    // For ambient occlusion, a record serves points nearer than its nearest hit: more records near surfaces.
    const float reach = records_.ambient(f.id()).nearest_hit;
    return weight * std::max(0.f, 1 - std::sqrt(f.distance2()) / reach);
}

Selection MapCache::select(const CachePoint& point, NeighbourList& around, uint32_t without) const {
    // Room for the record itself, which is left out afterwards.
    NearestSet set(parameters_.m_nearest + (without != kNoRecord), point.d_max);
    Selection s;
    for (const NearestSet::Found& f : candidates(point, set, around)) {
        if (f.id() == without || s.candidates == parameters_.m_nearest) continue;
        const float distance = std::sqrt(f.distance2());
        const float raw = record_weight(distance / point.d_max, normal_angle(point.normal, f.point->normal),
                                        float(parameters_.lambda));
        const float normalized = normalized_(raw);
        const float full = normalized * geometric_weight(point.normal, f.point->position - point.position,
                                                         distance, point.d_max);
        // Candidates come nearest first.
        if (!s.candidates++) s.nearest = distance;
        s.tested = std::max(s.tested, tested_weight(f, raw, normalized, full));
        // Insert into the list of the best. Nearer records came before and win ties
        int place = s.count;
        while (place > 0 && s.best[size_t(place - 1)].weight < full) --place;
        if (place == parameters_.n_best) continue;
        if (s.count < parameters_.n_best) ++s.count;
        for (int i = s.count - 1; i > place; --i) s.best[size_t(i)] = s.best[size_t(i - 1)];
        s.best[size_t(place)] = {f.id(), full};
    }
    return s;
}

float MapCache::mean_difference(const Selection& s) const {
    if (s.count < 2) return 0;
    float sum = 0;  // exact: every term is a multiple of 4^−m
    for (int i = 0; i < s.count; ++i)
        for (int j = i + 1; j < s.count; ++j)
            sum += map_difference(parameters_.m, records_.bits(s.best[size_t(i)].id),
                                  records_.bits(s.best[size_t(j)].id), count_differences_);
    // Mean over the pairs
    return sum / float(s.count * (s.count - 1) / 2);
}

Verdict MapCache::judge(const CachePoint& point, const Selection& s) const {
    // The order of the tests decides the reason that is counted: nothing in reach, too far away, or maps that
    // differ.
    if (!s.candidates) return Verdict::kNoCandidate;
    // Another record at the same place cannot help
    const auto unless_duplicate = [&](Verdict verdict) {
        const bool same = s.nearest < kCoincident * point.d_max && has_duplicate(point);
        return same ? Verdict::kDuplicate : verdict;
    };
    if (s.tested < w_min_) return unless_duplicate(Verdict::kWeight);
    if (parameters_.criterion == Criterion::kAmbient) return Verdict::kServed;
    if (!(mean_difference(s) > delta_max_)) return Verdict::kServed;
    // Differs (M36): at a contact shadow the maps never agree, and without this every pixel would get a
    // record
    if (s.nearest < float(parameters_.r_min_px) * point.footprint) return Verdict::kSuppressed;
    return unless_duplicate(Verdict::kDifference);
}

BlendedMaps MapCache::blend(const Selection& s) const {
    BlendedMaps maps{};
    maps.m = parameters_.m;
    float sum = 0;
    for (int i = 0; i < s.count; ++i) sum += s.best[size_t(i)].weight;
    if (!(sum > kLeastWeightSum)) return maps;
    // Weights descend: the first 0 ends the list.
    for (int i = 0; i < s.count && s.best[size_t(i)].weight > 0; ++i) {
        const uint32_t id = s.best[size_t(i)].id;
        // Eq. 8: β_i = w_i / Σ w
        maps.beta[i] = s.best[size_t(i)].weight / sum;
        maps.id[i] = id;
        maps.bits[i] = records_.bits(id);
        maps.hierarchy[i] = records_.hierarchy(id);
        for (int level = 1; level <= dilations(maps.m); ++level)
            maps.dilated[level - 1][i] = records_.dilated(id, level);
        maps.count = i + 1;
    }
    return maps;
}

bool MapCache::has_duplicate(const CachePoint& point) const {
    // The radius scales with the pixel: points closer than any pixel resolves are the same point.
    NearestSet set(1, kCoincident * point.d_max);
    tree_.search(
        point.position, [&](const TreePoint& p) { return length(p.normal - point.normal) < kCoincident; },
        set);
    return !set.sorted().empty();
}

uint32_t MapCache::add(const RecordHead& head, const Word* bits, const AmbientRecord& ambient) {
    const uint32_t id = records_.add(head, bits, ambient);
    tree_.insert({head.position, head.normal, id});
    return id;
}

void MapCache::keep(const std::vector<uint32_t>& ids) {
    // Ids are positions in the pool, so the tree is built anew with the new ones.
    records_.keep(ids);
    std::vector<TreePoint> points;
    for (uint32_t id = 0; id < records_.size(); ++id)
        points.push_back({records_.head(id).position, records_.head(id).normal, id});
    tree_.build(std::move(points));
}

}  // namespace viscache

#include "viscache/vismap/map_cache.h"

#include <stdexcept>
#include <string>

namespace viscache {

namespace {

constexpr float kLeastWeightSum = 1e-12f;

void require(bool holds, const char* what, double given) {
    if (!holds) throw std::invalid_argument(std::string(what) + ", got " + std::to_string(given));
}

}  // namespace

void MapCacheParameters::validate() const {
    require(m >= kMinMapLog2 && m <= kMaxMapLog2, "m must be in [4, 7]", m);
    require(n_best >= 1 && n_best <= kMaxBlended, "n_best must be in [1, 8]", n_best);
    require(m_nearest >= n_best && m_nearest <= NearestSet::kMost, "m_nearest must be in [n_best, 64]",
            m_nearest);
    require(theta_max_rad > 0 && theta_max_rad <= kPi, "theta_max must be in (0, 180] degrees",
            theta_max_rad * 180 / kPi);
    require(lambda >= 0 && lambda <= 1e6f, "lambda must be in [0, 1e6]", lambda);
    require(w_min >= 0 && w_min <= 1, "w_min must be in [0, 1]", w_min);
    require(delta_max >= 0 && delta_max <= 1, "delta_max must be in [0, 1]", delta_max);
    require(r_min_px >= 0 && r_min_px <= 1e6f, "r_min_px must be in [0, 1e6]", r_min_px);
    require(max_records >= 1 && max_records <= 1u << 26, "max_records must be in [1, 2^26]", max_records);
}

MapCache::MapCache(const MapCacheParameters& parameters, std::vector<Vec3> pattern)
    : parameters_((parameters.validate(), parameters)),
      pattern_(std::move(pattern)),
      records_(parameters.m),
      normalized_(parameters.theta_max_rad, parameters.lambda),
      cos_theta_max_(std::cos(parameters.theta_max_rad)),
      count_differences_(count_differences(active_isa())) {
    if (pattern_.size() != map_cells(parameters_.m))
        throw std::invalid_argument("pattern must have 4^m directions, " +
                                    std::to_string(map_cells(parameters_.m)) + ", got " +
                                    std::to_string(pattern_.size()));
}

void MapCache::set_thresholds(float w_min, float delta_max) {
    MapCacheParameters changed = parameters_;
    changed.w_min = w_min;
    changed.delta_max = delta_max;
    changed.validate();
    parameters_ = changed;
}

std::span<const NearestSet::Found> MapCache::candidates(const CachePoint& point, NearestSet& set,
                                                        NeighbourList& around) const {
    const auto similar = [&](Vec3 normal) { return dot(point.normal, normal) > cos_theta_max_; };
    if (parameters_.filter == SearchFilter::kDuring) {
        around.search(tree_, point.position, [&](const TreePoint& p) { return similar(p.normal); }, set);
        return set.sorted();
    }
    // Differs: Fig. 6 shows the test of normals after the search; the text of Sec. 5.1 makes it part of the
    // search
    around.search(tree_, point.position, [](const TreePoint&) { return true; }, set);
    return set.sorted_without([&](const NearestSet::Found& f) { return !similar(f.point->normal); });
}

float MapCache::tested_weight(const NearestSet::Found& f, float raw, float normalized, float full) const {
    const float weight = parameters_.weight_test == WeightTest::kFull         ? full
                         : parameters_.weight_test == WeightTest::kNormalized ? normalized
                                                                              : raw;
    if (parameters_.criterion == Criterion::kVisibility) return weight;
    const float reach = records_.ambient(f.id()).nearest_hit;
    return weight * std::max(0.f, 1 - std::sqrt(f.distance2()) / reach);
}

Selection MapCache::select(const CachePoint& point, NeighbourList& around, uint32_t without) const {
    NearestSet set(parameters_.m_nearest + (without != kNoRecord), point.d_max);
    Selection s;
    for (const NearestSet::Found& f : candidates(point, set, around)) {
        if (f.id() == without || s.candidates == parameters_.m_nearest) continue;
        const float distance = std::sqrt(f.distance2());
        const float raw = record_weight(distance / point.d_max, normal_angle(point.normal, f.point->normal),
                                        parameters_.lambda);
        const float normalized = normalized_(raw);
        const float full = normalized * geometric_weight(point.normal, f.point->position - point.position,
                                                         distance, point.d_max);
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
    return sum / float(s.count * (s.count - 1) / 2);
}

Verdict MapCache::judge(const CachePoint& point, const Selection& s) const {
    if (!s.candidates) return Verdict::kNoCandidate;
    // Another record at the same place cannot help
    const auto unless_duplicate = [&](Verdict verdict) {
        const bool same = s.nearest < kCoincident * point.d_max && has_duplicate(point);
        return same ? Verdict::kDuplicate : verdict;
    };
    if (s.tested < parameters_.w_min) return unless_duplicate(Verdict::kWeight);
    if (parameters_.criterion == Criterion::kAmbient) return Verdict::kServed;
    if (!(mean_difference(s) > parameters_.delta_max)) return Verdict::kServed;
    // Differs: at a contact shadow the maps never agree, and without this every pixel would get a record
    if (s.nearest < parameters_.r_min_px * point.footprint) return Verdict::kSuppressed;
    return unless_duplicate(Verdict::kDifference);
}

BlendedMaps MapCache::blend(const Selection& s) const {
    BlendedMaps maps{};
    maps.m = parameters_.m;
    float sum = 0;
    for (int i = 0; i < s.count; ++i) sum += s.best[size_t(i)].weight;
    if (!(sum > kLeastWeightSum)) return maps;
    for (int i = 0; i < s.count && s.best[size_t(i)].weight > 0; ++i) {
        const uint32_t id = s.best[size_t(i)].id;
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
    records_.keep(ids);
    std::vector<TreePoint> points;
    for (uint32_t id = 0; id < records_.size(); ++id)
        points.push_back({records_.head(id).position, records_.head(id).normal, id});
    tree_.build(std::move(points));
}

}  // namespace viscache

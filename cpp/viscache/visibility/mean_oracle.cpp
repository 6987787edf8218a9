#include "viscache/visibility/mean_oracle.h"

#include <bit>

#include "viscache/sampling/point_key.h"
#include "viscache/visibility/local_samples.h"

namespace viscache {

namespace {

/// Threshold of 32 random bits: a query is drawn below it.
uint64_t threshold(double q) { return uint64_t(std::clamp(std::floor(q * 0x1p32), 1.0, 0x1p32)); }

float inverse_share(uint64_t threshold) { return float(0x1p32 / double(threshold)); }

bool is_below(uint64_t key, uint64_t number, uint64_t threshold) {
    return (mix64(key + number * 0x9E3779B97F4A7C15ull) >> 32) < threshold;
}

double deviation(double mean) { return std::sqrt(mean * (1 - mean)); }

}  // namespace

MeanOracle::MeanOracle(const VoxelVisibility& map, const RayCaster& caster, float extent,
                       const MeanSettings& s)
    : map_(map),
      exact_(caster, extent, order_of_share(s.share.value_or(0))),
      share_(s.share),
      seed_(s.seed),
      lasting_seed_(s.lasting_seed),
      weighted_(s.weighted),
      row_of_voxel_(map.voxels(), kNone) {
    for (size_t b = 0; b < kPlanes; ++b) bands_below_[b] = float(std::ldexp(s.certain, -int(b)));
}

void MeanOracle::watch(const Control& control) {
    VisibilityOracle::watch(control);
    exact_.watch(control);
}

/// Random key of an eye point. It depends on its position, not on tiles or threads.
uint64_t MeanOracle::eye_key(const EyeBlock& eyes, size_t eye, int group) const {
    Rng rng(seed_, Purpose::kResidual, uint64_t(group), 0);
    return mix_point(rng.next_u32(), eyes.position[eye]);
}

/// Computes means and deviations of all columns for every voxel with eye points.
void MeanOracle::make_rows(const EyeBlock& eyes, const FarEnds& lights) {
    for (const auto& row : rows_) row_of_voxel_[row->voxel] = kNone;
    rows_.clear();
    far_.resize(lights.count);
    for (size_t k = 0; k < far_.size(); ++k)
        far_[k] = map_.far_cell(lights.semantic, {lights.x[k], lights.y[k], lights.z[k]});
    row_of_eye_.resize(eyes.size());
    for (size_t i = 0; i < eyes.size(); ++i) {
        const uint32_t voxel = map_.voxel(eyes.position[i]);
        if (row_of_voxel_[voxel] == kNone) {
            auto row = std::make_unique<Row>();
            row->voxel = voxel;
            row->mean.assign(lights.x.size(), 1.f);
            for (auto& plane : row->steady) plane.assign(words_for(lights.count), 0);
            for (size_t k = 0; k < far_.size(); ++k) {
                const double mean = map_.mean(voxel, far_[k]), d = deviation(mean);
                row->mean[k] = float(mean);
                for (size_t j = 0; j < kPlanes && d <= std::ldexp(0.25, -int(j)); ++j)
                    set_bit(row->steady[j].data(), k);
            }
            row_of_voxel_[voxel] = uint32_t(rows_.size());
            rows_.push_back(std::move(row));
        }
        row_of_eye_[i] = row_of_voxel_[voxel];
    }
}

void MeanOracle::draw_evenly(const EyeBlock& eyes, uint32_t eye, int group, const BitMatrix& wanted) {
    const uint64_t key = eye_key(eyes, eye, group), below = threshold(*share_);
    for_each_bit(wanted.row_span(eye), [&](size_t k) {
        if (!is_below(key, k, below)) return;
        drawn_.set(eye, k);
        inverse_.push_back(inverse_share(below));
    });
}

/// Draws 64 queries at once. Plane n has the queries with at least n + 1 halvings of q, by contribution and
/// by deviation together; each plane clears its queries with probability one half. Samples of a pixel have
/// the same random words in turns of 2^kHalvings, and the bits of a sample's number say which half is
/// cleared.
void MeanOracle::draw_by_contribution(const EyeBlock& eyes, uint32_t eye, int group,
                                      const BitMatrix& wanted) {
    const bool lasts = !eyes.place.empty();
    const uint32_t turn = lasts ? eyes.turn[eye] : 0;
    uint64_t key = eye_key(eyes, eye, group);
    if (lasts) key = Rng(lasting_seed_, Purpose::kResidual, eyes.place[eye], turn >> kPlanes).next_u64();
    key ^= mix64(uint64_t(group));
    if (contributions_) {
        std::array<Word*, kPlanes> below;
        for (size_t b = 0; b < kPlanes; ++b) below[b] = bands_.row(b);
        // Bounds are shares of the light; contributions are told in means
        uint64_t asked = 0;
        for (const Word word : wanted.row_span(eye)) asked += uint64_t(std::popcount(word));
        std::array<float, kPlanes> bounds = bands_below_;
        for (float& bound : bounds) bound *= float(asked);
        contributions_->at_most(eye, bounds, below);
    }
    const Row& row = *rows_[row_of_eye_[eye]];
    Word* drawn = drawn_.row(eye);
    for (size_t w = 0; w < words_for(wanted.columns()); ++w) {
        Word left = wanted.row(eye)[w];
        if (!left) continue;
        std::array<Word, kPlanes + 1> small, steady;  // at least so many halvings
        small[0] = steady[0] = ~Word{0};
        for (size_t b = 0; b < kPlanes; ++b) {
            small[b + 1] = contributions_ ? bands_.row(b)[w] : 0;
            steady[b + 1] = row.steady[b][w];
        }
        for (size_t n = 1; n <= kPlanes; ++n) {
            Word plane = 0;
            for (size_t b = 0; b <= n; ++b) plane |= small[b] & steady[n - b];
            planes_.row(n - 1)[w] = plane;
            left &= ~plane | (mix64(key + (w * kPlanes + n) * 0x9E3779B97F4A7C15ull) ^
                              (turn >> (n - 1) & 1 ? ~Word{0} : Word{0}));
        }
        drawn[w] = left;
    }
    for_each_bit(drawn_.row_span(eye), [&](size_t k) {
        int h = 0;
        for (size_t n = 0; n < kPlanes; ++n) h += get_bit(planes_.row(n), k);
        inverse_.push_back(std::ldexp(1.f, h));
    });
}

void MeanOracle::block(const EyeBlock& eyes, const FarEnds& lights, const BitMatrix& wanted,
                       BitMatrix& visible, Counters& counters) {
    corrections_.clear();
    correction_begin_.clear();
    traced_all_ = is_exact(lights);
    if (traced_all_) {
        const uint64_t before = counters.rays();
        exact_.block(eyes, lights, wanted, visible, counters);
        counters.corrections += counters.rays() - before;
        return;
    }
    make_rows(eyes, lights);
    drawn_.reset(wanted.rows(), lights.count);
    bands_.reset(kPlanes, lights.count);
    planes_.reset(kPlanes, lights.count);
    seen_.reset(wanted.rows(), lights.count);
    inverse_.clear();
    for (uint32_t i = 0; i < wanted.rows(); ++i) {
        if (i % 256 == 0) check_cancelled();
        share_ ? draw_evenly(eyes, i, lights.group, wanted)
               : draw_by_contribution(eyes, i, lights.group, wanted);
    }
    Counters traced;
    exact_.block(eyes, lights, drawn_, seen_, traced);
    GroupCounters& group = counters.group(lights.group);
    group.queries += count_bits(wanted);
    group.rays += traced.rays();
    group.occluded += traced.group(lights.group).occluded;
    counters.corrections += traced.rays();
    for (size_t i = 0; i < wanted.rows(); ++i)
        std::copy_n(wanted.row(i), words_for(lights.count), visible.row(i));

    correction_begin_.push_back(0);
    size_t number = 0;
    for (size_t i = 0; i < wanted.rows(); ++i) {
        const std::vector<float>& mean = rows_[row_of_eye_[i]]->mean;
        for_each_bit(drawn_.row_span(i), [&](size_t k) {
            const float change = float(seen_.get(i, k)) - mean[k], times = inverse_[number++];
            corrections_.push_back({uint32_t(k), weighted_ ? change * times : change, 1 / times});
        });
        correction_begin_.push_back(uint32_t(corrections_.size()));
    }
}

void MeanOracle::samples(const EyeBlock& eyes, const LocalSamples& samples, std::span<Word> visible,
                         Counters& counters) {
    if (!is_exact_own(samples.group)) return VisibilityOracle::samples(eyes, samples, visible, counters);
    pair_weights_.clear();
    const uint64_t before = counters.rays();
    exact_.samples(eyes, samples, visible, counters);
    counters.corrections += counters.rays() - before;
}

void MeanOracle::pairs(const EyeBlock& eyes, std::span<const ShadowQuery> queries, std::span<Word> visible,
                       Counters& counters) {
    pair_weights_.resize(queries.size());
    std::vector<uint32_t> number;
    std::vector<ShadowQuery> drawn;
    inverse_.clear();
    for (uint32_t i = 0; i < queries.size(); ++i) {
        const ShadowQuery& q = queries[i];
        const double mean = map_.mean(map_.voxel(eyes.position[q.eye]), map_.far_cell(q.semantic, q.far));
        const uint64_t below =
            threshold(share_.value_or(std::max(std::ldexp(1.0, -int(kPlanes)), 2 * deviation(mean))));
        pair_weights_[i] = float(mean);
        ++counters.group(q.group).queries;
        if (!is_below(mix_point(eye_key(eyes, q.eye, q.group), q.far), 0, below)) continue;
        number.push_back(i);
        drawn.push_back(q);
        inverse_.push_back(inverse_share(below));
    }
    std::vector<Word> seen(words_for(drawn.size()));
    Counters traced;
    exact_.pairs(eyes, drawn, seen, traced);
    for (int g = 0; g < kLightGroups; ++g) {
        counters.group(g).rays += traced.group(g).rays;
        counters.group(g).occluded += traced.group(g).occluded;
    }
    counters.corrections += traced.rays();
    for (size_t d = 0; d < drawn.size(); ++d) {
        const float truth = float(get_bit(seen.data(), d)), mean = pair_weights_[number[d]];
        // At q = 1 this is the true visibility without rounding
        pair_weights_[number[d]] =
            inverse_[d] == 1 ? truth : mean + (truth - mean) * (weighted_ ? inverse_[d] : 1.f);
    }
    for (size_t i = 0; i < queries.size(); ++i)
        if (pair_weights_[i] != 0) set_bit(visible.data(), i);
}

}  // namespace viscache

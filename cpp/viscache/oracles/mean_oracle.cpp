#include "viscache/oracles/mean_oracle.h"

#include <bit>

namespace viscache {

namespace {

/// Of a bit with this mean: how wrong the mean may be as an answer.
double deviation(double mean) { return std::sqrt(mean * (1 - mean)); }

}  // namespace

MeanOracle::MeanOracle(const VoxelVisibility& map, const RayCaster& caster, const MeanSettings& s)
    : map_(map),
      exact_(caster, order_of_share(s.share.value_or(0))),
      share_(s.share),
      keys_{s.seed, Purpose::kResidual, s.lasting_seed},
      weighted_(s.weighted),
      voxels_(map) {
    wrap(exact_);
    // Each band has half of the contribution of the one before, and gets half of its rays
    for (size_t b = 0; b < kPlanes; ++b) bands_below_[b] = float(std::ldexp(s.certain, -int(b)));
}

/// Computes means and deviations of all columns for every voxel with eye points.
void MeanOracle::make_rows(const BlockAsk& ask) {
    weights_.clear();
    steady_.clear();
    const size_t words = words_for(ask.lights.count);
    voxels_.make(ask, [&](uint32_t voxel, std::span<const uint32_t> far) {
        const size_t first = steady_.size();
        steady_.resize(first + kPlanes * words);
        for (size_t k = 0; k < far.size(); ++k) {
            const double mean = map_.mean(voxel, far[k]), d = deviation(mean);
            weights_.push_back(float(mean));
            // Half of the deviation allows half of the rays; 1/2 is the largest there is
            for (size_t j = 0; j < kPlanes && d <= std::ldexp(0.25, -int(j)); ++j)
                set_bit(steady_.data() + first + j * words, k);
        }
    });
}

void MeanOracle::draw_evenly(const BlockAsk& ask, uint32_t eye) {
    const uint64_t key = keys_.of(ask.eyes, eye, ask.lights.group);
    const RandomShare share(*share_);
    for_each_bit(ask.wanted.row_span(eye), [&](size_t k) {
        if (!share.draws(key, k)) return;
        drawn_.set(eye, k);
        inverse_.push_back(share.inverse);
    });
}

/// Draws 64 queries at once. Plane n has the queries with at least n + 1 halvings of q, by contribution and
/// by deviation together; each plane clears its queries with probability one half. Samples of a pixel have
/// the same random words in turns of 2^kHalvings, and the bits of a sample's number say which half is
/// cleared.
void MeanOracle::draw_by_contribution(const BlockAsk& ask, uint32_t eye) {
    const EyeBlock& eyes = ask.eyes;
    const BitMatrix& wanted = ask.wanted;
    // Arrays of points have no samples of pixels
    const uint32_t turn = eyes.place.empty() ? 0 : eyes.turn[eye];
    const uint64_t key = keys_.of_turns(eyes, eye, ask.lights.group, kPlanes);
    if (ask.contributions) {
        std::array<Word*, kPlanes> below;
        for (size_t b = 0; b < kPlanes; ++b) below[b] = bands_.row(b);
        // Bounds are shares of the light; contributions are told in means
        uint64_t asked = 0;
        for (const Word word : wanted.row_span(eye)) asked += uint64_t(std::popcount(word));
        std::array<float, kPlanes> bounds = bands_below_;
        for (float& bound : bounds) bound *= float(asked);
        ask.contributions->at_most(eye, bounds, below);
    }
    const size_t words = words_for(wanted.columns());
    const Word* steady_row = steady_.data() + voxels_.of_eyes()[eye] * kPlanes * words;
    Word* drawn = drawn_.row(eye);
    for (size_t w = 0; w < words; ++w) {
        Word left = wanted.row(eye)[w];
        if (!left) continue;
        // Halvings of both kinds add up: n of them are b by contribution and n − b by deviation,
        // for some b
        std::array<Word, kPlanes + 1> small, steady;  // at least so many halvings
        small[0] = steady[0] = ~Word{0};
        for (size_t b = 0; b < kPlanes; ++b) {
            small[b + 1] = ask.contributions ? bands_.row(b)[w] : 0;
            steady[b + 1] = steady_row[b * words + w];
        }
        for (size_t n = 1; n <= kPlanes; ++n) {
            Word plane = 0;
            for (size_t b = 0; b <= n; ++b) plane |= small[b] & steady[n - b];
            planes_.row(n - 1)[w] = plane;
            // Outside of the plane nothing is cleared; inside, half of the bits at random
            left &= ~plane | (mix64(key + (w * kPlanes + n) * 0x9E3779B97F4A7C15ull) ^
                              (turn >> (n - 1) & 1 ? ~Word{0} : Word{0}));
        }
        drawn[w] = left;
    }
    for_each_bit(drawn_.row_span(eye), [&](size_t k) {
        // Planes are nested, so their number at a query is the number of its halvings: q = 2^−h
        int h = 0;
        for (size_t n = 0; n < kPlanes; ++n) h += get_bit(planes_.row(n), k);
        inverse_.push_back(std::ldexp(1.f, h));
    });
}

/// The answer of exact rays to all queries of an ask. They count as corrections.
Answer MeanOracle::traced(Answer exact, uint64_t rays_before, Counters& counters) const {
    counters.corrections += counters.rays() - rays_before;
    return {.bits = exact.bits, .exact = exact.exact};
}

Answer MeanOracle::block(const BlockAsk& ask, Counters& counters) {
    const BitMatrix& wanted = ask.wanted;
    if (share_ ? traces_all() : ask.lights.count <= MeanSettings::kFewLights) {
        const uint64_t before = counters.rays();
        return traced(exact_.block(ask, counters), before, counters);
    }
    make_rows(ask);
    drawn_.reset(wanted.rows(), ask.lights.count);
    bands_.reset(kPlanes, ask.lights.count);
    planes_.reset(kPlanes, ask.lights.count);
    inverse_.clear();
    for (uint32_t i = 0; i < wanted.rows(); ++i) {
        if (i % 256 == 0) check_cancelled();
        share_ ? draw_evenly(ask, i) : draw_by_contribution(ask, i);
    }
    Counters counted;
    const Answer seen = exact_.block({ask.eyes, ask.lights, drawn_}, counted);
    GroupCounters& group = counters.group(ask.lights.group);
    group.queries += count_bits(wanted);
    group.rays += counted.rays();
    group.occluded += counted.group(ask.lights.group).occluded;
    counters.corrections += counted.rays();

    // Every query counts with the mean of its voxels, and a traced one also with its correction
    BitMatrix& visible = new_bits(wanted.rows(), wanted.columns());
    const Answer means{.bits = &visible, .weights = weights_, .weight_row = voxels_.of_eyes()};
    corrections_.clear();
    correction_begin_.assign(1, 0);
    size_t number = 0;
    for (size_t i = 0; i < wanted.rows(); ++i) {
        std::ranges::copy(wanted.row_span(i), visible.row(i));
        const std::span<const float> mean = means.weights_of(i);
        for_each_bit(drawn_.row_span(i), [&](size_t k) {
            // The residual over its probability: in the mean, the truth
            const float change = float(seen.bits->get(i, k)) - mean[k], times = inverse_[number++];
            corrections_.push_back({uint32_t(k), weighted_ ? change * times : change, 1 / times});
        });
        correction_begin_.push_back(uint32_t(corrections_.size()));
    }
    Answer out = means;
    out.corrections = corrections_;
    out.correction_begin = correction_begin_;
    return out;
}

Answer MeanOracle::pairs(const PairsAsk& ask, Counters& counters) {
    if (ask.samples && (!share_ || traces_all())) {
        const uint64_t before = counters.rays();
        return traced(exact_.pairs(ask, counters), before, counters);
    }
    std::vector<ShadowQuery> made, drawn;
    std::vector<uint32_t> number;
    const std::span<const ShadowQuery> queries = ask.as_queries(made);
    weights_.clear();
    inverse_.clear();
    for (uint32_t i = 0; i < queries.size(); ++i) {
        const ShadowQuery& q = queries[i];
        const double mean = map_.mean(map_.voxel(ask.eyes.position[q.eye]), map_.far_cell(q.semantic, q.far));
        const RandomShare share(
            // A deviation of 1/2 is certain to be traced; the least share is that of blocks
            share_.value_or(std::max(std::ldexp(1.0, -int(kPlanes)), 2 * deviation(mean))));
        weights_.push_back(float(mean));
        ++counters.group(q.group).queries;
        if (!share.draws(mix_point(keys_.of(ask.eyes, q.eye, q.group), q.far), 0)) continue;
        number.push_back(i);
        drawn.push_back(q);
        inverse_.push_back(share.inverse);
    }
    Counters counted;
    const Answer seen = exact_.pairs({ask.eyes, drawn}, counted);
    for (int g = 0; g < kLightGroups; ++g) {
        counters.group(g).rays += counted.group(g).rays;
        counters.group(g).occluded += counted.group(g).occluded;
    }
    counters.corrections += counted.rays();
    for (size_t d = 0; d < drawn.size(); ++d) {
        const float truth = float(seen.bits->get(0, d)), mean = weights_[number[d]];
        // At q = 1 this is the true visibility without rounding
        weights_[number[d]] =
            inverse_[d] == 1 ? truth : mean + (truth - mean) * (weighted_ ? inverse_[d] : 1.f);
    }
    BitMatrix& visible = new_bits(1, queries.size());
    for (size_t i = 0; i < queries.size(); ++i)
        // A weight of 0 is an answer of "blocked"
        if (weights_[i] != 0) visible.set(0, i);
    if (traces_all()) return {.bits = &visible, .exact = LightGroupSet().set()};
    return {.bits = &visible, .weights = weights_};
}

}  // namespace viscache

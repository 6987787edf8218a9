#include "viscache/visibility/residual_oracle.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "viscache/sampling/point_key.h"
#include "viscache/visibility/local_samples.h"

namespace viscache {

ResidualOracle::ResidualOracle(std::unique_ptr<VisibilityOracle> inner, const RayCaster& caster, float extent,
                               const ResidualSettings& s)
    : inner_(std::move(inner)),
      exact_(caster, extent, order_of_share(s.share.value_or(0))),
      share_(s.share),
      octaves_(s.octaves),
      seed_(s.seed),
      lasting_seed_(s.lasting_seed),
      weighted_(s.weighted),
      threshold_(uint64_t(
          std::clamp(std::floor(s.share.value_or(ResidualSettings::kPlainShare) * 0x1p32), 1.0, 0x1p32))),
      inverse_share_(float(0x1p32 / double(threshold_))) {
    for (size_t b = 0; b < bounds_.size(); ++b)
        bounds_[b] = float(std::ldexp(s.certain, int(kMostOctaves - kPlainOctave) - int(b)));
}

void ResidualOracle::watch(const Control& control) {
    VisibilityOracle::watch(control);
    inner_->watch(control);
    exact_.watch(control);
}

void ResidualOracle::begin_tile(const EyeBlock& eyes) {
    inner_->begin_tile(eyes);
    exact_.begin_tile(eyes);
}

/// Random key of an eye point. It depends on its position, not on tiles or threads.
uint64_t ResidualOracle::eye_key(const EyeBlock& eyes, size_t eye, int group) const {
    Rng rng(seed_, Purpose::kResidual, uint64_t(group), 0);
    return mix_point(rng.next_u32(), eyes.position[eye]);
}

bool ResidualOracle::is_drawn(uint64_t key, uint64_t number) const {
    return (mix64(key + number * 0x9E3779B97F4A7C15ull) >> 32) < threshold_;
}

/// Chooses the queries whose rays are traced.
void ResidualOracle::draw(const EyeBlock& eyes, const FarEnds& lights, const BitMatrix& wanted,
                          const BitMatrix& visible, Counters& counters) {
    drawn_.reset(wanted.rows(), lights.count);
    drawn_as_.clear();
    if (by_contribution()) masks_.reset(bounds_.size() + ResidualSettings::kHalvings + 2, lights.count);
    for (size_t i = 0; i < wanted.rows(); ++i) {
        if (i % 256 == 0) check_cancelled();
        if (by_contribution()) {
            draw_by_contribution(eyes, uint32_t(i), lights.group, wanted, visible, counters);
        } else {
            const uint64_t key = eye_key(eyes, i, lights.group);
            for_each_bit(wanted.row_span(i), [&](size_t k) {
                if (is_drawn(key, k)) drawn_.set(i, k);
            });
        }
    }
}

/// Each bound that lies above a query's contribution clears it with probability one half. Samples of a pixel
/// have the same random words in turns of 2^kHalvings, and the bits of a sample's number say which half is
/// cleared.
void ResidualOracle::draw_by_contribution(const EyeBlock& eyes, uint32_t eye, int group,
                                          const BitMatrix& wanted, const BitMatrix& visible,
                                          Counters& counters) {
    constexpr size_t kBands = ResidualSettings::kHalvings, kOctaves = kMostOctaves;
    const size_t words = wanted.row_words();
    const uint64_t asked = kernels_.count(wanted.row(eye), words);
    if (asked == 0) return;
    const bool lasts = !eyes.place.empty();
    const uint32_t turn = lasts ? eyes.turn[eye] : 0;
    uint64_t key = eye_key(eyes, eye, group);
    if (lasts) key = Rng(lasting_seed_, Purpose::kResidual, eyes.place[eye], turn >> kBands).next_u64();
    key ^= mix64(uint64_t(group));

    // Bounds that a class of this group uses. They are shares of a light; contributions are told in means
    const float known = contributions_->reference(eye, visible.row(eye));
    const float light = known > 0 ? known : float(asked);
    const auto& octaves = octaves_[size_t(group)];
    const size_t first = kOctaves - *std::max_element(octaves.begin(), octaves.end());
    std::array<Word*, kOctaves + kBands> below{};
    std::array<float, kOctaves + kBands> bounds;
    for (size_t b = first; b < below.size(); ++b) {
        below[b] = masks_.row(b);
        bounds[b] = bounds_[b] * light;
    }
    contributions_->at_most(eye, std::span(bounds).subspan(first), std::span(below).subspan(first));

    Word *under = masks_.row(below.size()), *differs = masks_.row(below.size() + kBands);
    const Word* none = masks_.row(below.size() + kBands + 1);
    const BitMatrix* doubts = inner_->block_doubts();
    kernels_.differs(wanted.row(eye), visible.row(eye), differs, words);
    DrawRow row{words,
                wanted.row(eye),
                visible.row(eye),
                doubts ? doubts->row(eye) : none,
                differs,
                {},
                &octaves,
                key,
                turn};
    std::copy(below.begin(), below.end(), row.below.begin());
    std::array<uint64_t, kAnswerClasses> queries{};
    kernels_.draw(row, drawn_.row(eye), under, queries.data());
    for (size_t c = 0; c < kAnswerClasses; ++c) counters.classes[size_t(group)][c].queries += queries[c];
    for_each_bit(drawn_.row_span(eye), [&](size_t k) {
        Drawn d{0, 0};
        for (size_t b = 0; b < kBands; ++b) d.halvings += uint8_t(get_bit(under + b * words, k));
        d.answer_class =
            uint8_t(4 * get_bit(row.doubts, k) + 2 * get_bit(row.visible, k) + get_bit(differs, k));
        drawn_as_.push_back(d);
    });
}

void ResidualOracle::block(const EyeBlock& eyes, const FarEnds& lights, const BitMatrix& wanted,
                           BitMatrix& visible, Counters& counters) {
    corrections_.clear();
    correction_begin_.clear();
    replaces_ = false;
    inner_->block(eyes, lights, wanted, visible, counters);
    if (inner_->is_exact(lights)) {
        for (size_t i = 0; i < wanted.rows(); ++i)
            for (const Word word : wanted.row_span(i))
                counters.exact_queries += uint64_t(std::popcount(word));
        return;
    }
    draw(eyes, lights, wanted, visible, counters);
    seen_.reset(wanted.rows(), lights.count);
    Counters traced;
    exact_.block(eyes, lights, drawn_, seen_, traced);
    counters.group(lights.group).rays += traced.rays();
    counters.corrections += traced.rays();

    correction_begin_.push_back(0);
    replaces_ = !by_contribution() && inverse_share_ == 1;
    size_t number = 0;
    for (size_t i = 0; i < wanted.rows(); ++i) {
        const std::span<const float> inner = block_weights(uint32_t(i));
        for_each_bit(drawn_.row_span(i), [&](size_t k) {
            const Drawn as = by_contribution() ? drawn_as_[number++] : Drawn{0, 0};
            const bool answer = visible.get(i, k), truth = seen_.get(i, k);
            counters.wrong += answer != truth;
            if (by_contribution()) {
                ClassCounters& of_class = counters.classes[size_t(lights.group)][as.answer_class];
                ++of_class.checked;
                of_class.wrong += answer != truth;
            }
            const float value = !answer ? 0.f : inner.empty() ? 1.f : inner[k];
            const float change = correction(value, truth, as.halvings);
            if (change == 0) return;
            // Without weights, a change by 1 is one of the bit: a share of 1 gives the exact frame
            if (inner.empty() && std::fabs(change) == 1)
                truth ? set_bit(visible.row(i), k) : clear_bit(visible.row(i), k);
            else
                corrections_.push_back({uint32_t(k), change, share_of(as.halvings)});
        });
        correction_begin_.push_back(uint32_t(corrections_.size()));
    }
}

void ResidualOracle::pairs(const EyeBlock& eyes, std::span<const ShadowQuery> queries,
                           std::span<Word> visible, Counters& counters) {
    inner_->pairs(eyes, queries, visible, counters);
    correct(eyes, queries, visible, counters);
}

void ResidualOracle::samples(const EyeBlock& eyes, const LocalSamples& samples, std::span<Word> visible,
                             Counters& counters) {
    inner_->samples(eyes, samples, visible, counters);
    if (inner_->is_exact_own(samples.group)) {
        counters.exact_queries += samples.size();
        const std::span<const float> inner = inner_->pair_weights();
        pair_weights_.assign(inner.begin(), inner.end());
        pair_corrections_.clear();
        return;
    }
    std::vector<ShadowQuery> queries;
    queries.reserve(samples.size());
    for_each_sample(samples, [&](uint32_t eye, size_t i) { queries.push_back(samples.query(eye, i)); });
    correct(eyes, queries, visible, counters);
}

void ResidualOracle::correct(const EyeBlock& eyes, std::span<const ShadowQuery> queries,
                             std::span<Word> visible, Counters& counters) {
    std::vector<uint32_t> number;
    std::vector<ShadowQuery> drawn;
    for (uint32_t i = 0; i < queries.size(); ++i) {
        const ShadowQuery& q = queries[i];
        if (inner_->is_exact_own(q.group)) {
            ++counters.exact_queries;
            continue;
        }
        if (!is_drawn(mix_point(eye_key(eyes, q.eye, q.group), q.far), 0)) continue;
        number.push_back(i);
        drawn.push_back(q);
    }
    std::vector<Word> seen(words_for(drawn.size()));
    Counters traced;
    exact_.pairs(eyes, drawn, seen, traced);
    for (int g = 0; g < kLightGroups; ++g) counters.group(g).rays += traced.group(g).rays;
    counters.corrections += traced.rays();
    const std::span<const float> inner = inner_->pair_weights();
    if (inner.empty())
        pair_weights_.assign(queries.size(), 1.f);
    else
        pair_weights_.assign(inner.begin(), inner.end());
    pair_corrections_.clear();
    for (size_t d = 0; d < drawn.size(); ++d) {
        const uint32_t i = number[d];
        const bool answer = get_bit(visible.data(), i), truth = get_bit(seen.data(), d);
        counters.wrong += answer != truth;
        const float value = answer ? pair_weights_[i] : 0.f;
        // At q = 1 this is the true visibility without rounding
        const float weight = inverse_share_ == 1
                                 ? float(truth)
                                 : value + (float(truth) - value) * (weighted_ ? inverse_share_ : 1.f);
        if (answer != truth || value != 1)
            pair_corrections_.push_back({i, weight - value, 1 / inverse_share_});
        pair_weights_[i] = weight;
        weight == 0 ? clear_bit(visible.data(), i) : set_bit(visible.data(), i);
    }
}

}  // namespace viscache

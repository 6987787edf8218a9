#include "viscache/oracles/residual_oracle.h"

#include <algorithm>
#include <cmath>

#include "viscache/visibility/local_samples.h"

namespace viscache {

ResidualOracle::ResidualOracle(std::unique_ptr<VisibilityOracle> inner, const RayCaster& caster,
                               const ResidualSettings& s)
    : inner_(std::move(inner)),
      exact_(caster, order_of_share(s.share.value_or(0))),
      has_share_(s.share.has_value()),
      share_(s.share.value_or(ResidualSettings::kPlainShare)),
      octaves_(s.octaves),
      keys_{s.seed, Purpose::kResidual, s.lasting_seed},
      weighted_(s.weighted) {
    wrap(*inner_);
    wrap(exact_);
    for (size_t b = 0; b < bounds_.size(); ++b)
        bounds_[b] = float(std::ldexp(s.certain, int(kMostOctaves - kPlainOctave) - int(b)));
}

void ResidualOracle::begin_tile(const EyeBlock& eyes) {
    inner_->begin_tile(eyes);
    exact_.begin_tile(eyes);
}

/// Draws queries of one eye point for a ray, all with the same probability.
void ResidualOracle::draw_evenly(const BlockAsk& ask, uint32_t eye) {
    const uint64_t key = keys_.of(ask.eyes, eye, ask.lights.group);
    for_each_bit(ask.wanted.row_span(eye), [&](size_t k) {
        if (!share_.draws(key, k)) return;
        drawn_.set(eye, k);
        drawn_as_.push_back({share_.inverse, 0});
    });
}

/// Draws queries of one eye point for a ray by half-clearing masks: see the picture in the header.
void ResidualOracle::draw_by_contribution(const BlockAsk& ask, const Answer& inner, uint32_t eye,
                                          Counters& counters) {
    const size_t group = size_t(ask.lights.group), words = ask.wanted.row_words();
    const Word *wanted = ask.wanted.row(eye), *visible = inner.bits->row(eye);
    const uint64_t asked = kernels_.count(wanted, words);
    if (asked == 0) return;

    // Which queries lie below which bound. Bounds are shares of a light, and contributions are compared in
    // means. Bounds above the highest that a class of this group counts are left out
    const float known = ask.contributions->reference(eye, visible);
    const float light = known > 0 ? known : float(asked);
    const auto& octaves = octaves_[group];
    const size_t highest = kMostOctaves - *std::max_element(octaves.begin(), octaves.end());
    std::array<float, kBounds> bounds;
    std::array<Word*, kBounds> below_bound{};
    for (size_t b = highest; b < kBounds; ++b) {
        bounds[b] = bounds_[b] * light;
        below_bound[b] = below_bound_.row(b);
    }
    ask.contributions->at_most(eye, std::span(bounds).subspan(highest),
                               std::span(below_bound).subspan(highest));

    kernels_.differs(wanted, visible, differs_.row(0), words);
    DrawRow row{.words = words,
                .wanted = wanted,
                .visible = visible,
                .doubts = inner.doubts ? inner.doubts->row(eye) : none_.row(0),
                .differs = differs_.row(0),
                .octaves = &octaves,
                .key = keys_.of_turns(ask.eyes, eye, int(group), kMostHalvings),
                .turn = ask.eyes.place.empty() ? 0 : ask.eyes.turn[eye]};
    std::ranges::copy(below_bound, row.below_bound.begin());
    std::array<uint64_t, kAnswerClasses> queries{};
    kernels_.draw(row, drawn_.row(eye), halved_.row(0), queries.data());

    // The share and the class of each drawn query, and what its class asked
    for (size_t c = 0; c < kAnswerClasses; ++c) counters.classes[group][c].queries += queries[c];
    for_each_bit(drawn_.row_span(eye), [&](size_t k) {
        int halvings = 0;
        for (size_t h = 0; h < kMostHalvings; ++h) halvings += halved_.get(h, k);
        const int answer_class =
            4 * get_bit(row.doubts, k) + 2 * get_bit(row.visible, k) + get_bit(row.differs, k);
        drawn_as_.push_back({std::ldexp(1.f, halvings), uint8_t(answer_class)});
    });
}

Answer ResidualOracle::block(const BlockAsk& ask, Counters& counters) {
    const size_t rows = ask.wanted.rows(), columns = ask.lights.count;
    Answer answer = inner_->block({ask.eyes, ask.lights, ask.wanted, ask.contributions}, counters);
    if (answer.is_exact(ask.lights.group)) {
        counters.exact_queries += count_bits(ask.wanted);
        return answer;
    }
    // Draw the queries whose rays are traced
    const bool by_contribution = !has_share_ && ask.contributions;
    drawn_.reset(rows, columns);
    drawn_as_.clear();
    if (by_contribution) {
        below_bound_.reset(kBounds, columns);
        halved_.reset(kMostHalvings, columns);
        differs_.reset(1, columns);
        none_.reset(1, columns);
    }
    for (uint32_t i = 0; i < rows; ++i) {
        if (i % 256 == 0) check_cancelled();
        by_contribution ? draw_by_contribution(ask, answer, i, counters) : draw_evenly(ask, i);
    }
    // Trace them
    Counters traced;
    const Answer seen = exact_.block({ask.eyes, ask.lights, drawn_}, traced);
    counters.group(ask.lights.group).rays += traced.rays();
    counters.corrections += traced.rays();
    correct(ask, *seen.bits, by_contribution, answer, counters);
    return answer;
}

/// Compares the traced rays with the answers, and adds the corrections.
void ResidualOracle::correct(const BlockAsk& ask, const BitMatrix& seen, bool by_contribution, Answer& answer,
                             Counters& counters) {
    BitMatrix& visible = *answer.bits;
    // If every answer is replaced by the truth, none has a weight
    if (!by_contribution && share_.inverse == 1) answer.weights = {};
    corrections_.clear();
    correction_begin_.assign(1, 0);
    size_t number = 0;
    for (size_t i = 0; i < visible.rows(); ++i) {
        const std::span<const float> weights = answer.weights_of(i);
        for_each_bit(drawn_.row_span(i), [&](size_t k) {
            const Drawn as = drawn_as_[number++];
            const bool said = visible.get(i, k), truth = seen.get(i, k);
            counters.wrong += said != truth;
            if (by_contribution) {
                ClassCounters& of_class = counters.classes[size_t(ask.lights.group)][as.answer_class];
                ++of_class.checked;
                of_class.wrong += said != truth;
            }
            const float value = !said ? 0.f : weights.empty() ? 1.f : weights[k];
            const float change = (float(truth) - value) * (weighted_ ? as.inverse_share : 1.f);
            if (change == 0) return;
            // Without weights, a change by 1 is one of the bit: a share of 1 gives the exact frame
            if (weights.empty() && std::fabs(change) == 1)
                truth ? set_bit(visible.row(i), k) : clear_bit(visible.row(i), k);
            else
                corrections_.push_back({uint32_t(k), change, 1 / as.inverse_share});
        });
        correction_begin_.push_back(uint32_t(corrections_.size()));
    }
    answer.corrections = corrections_;
    answer.correction_begin = correction_begin_;
}

Answer ResidualOracle::pairs(const PairsAsk& ask, Counters& counters) {
    Answer answer = inner_->pairs(ask, counters);
    if (ask.samples && answer.is_exact(ask.samples->group)) {
        counters.exact_queries += ask.size();
        return answer;
    }
    // Draw the queries whose rays are traced, and trace them
    std::vector<ShadowQuery> made, drawn;
    const std::span<const ShadowQuery> queries = ask.as_queries(made);
    std::vector<uint32_t> number;
    for (uint32_t i = 0; i < queries.size(); ++i) {
        const ShadowQuery& q = queries[i];
        if (answer.is_exact(q.group)) {
            ++counters.exact_queries;
            continue;
        }
        if (!share_.draws(mix_point(keys_.of(ask.eyes, q.eye, q.group), q.far), 0)) continue;
        number.push_back(i);
        drawn.push_back(q);
    }
    Counters traced;
    const Answer seen = exact_.pairs({ask.eyes, drawn}, traced);
    for (int g = 0; g < kLightGroups; ++g) counters.group(g).rays += traced.group(g).rays;
    counters.corrections += traced.rays();

    // The weights of pairs include the corrections
    weights_.assign(queries.size(), 1.f);
    std::ranges::copy(answer.weights, weights_.begin());
    corrections_.clear();
    for (size_t d = 0; d < drawn.size(); ++d) {
        const uint32_t i = number[d];
        const bool said = answer.bits->get(0, i), truth = seen.bits->get(0, d);
        counters.wrong += said != truth;
        const float value = said ? weights_[i] : 0.f;
        // At q = 1 this is the true visibility without rounding
        const float weight = share_.inverse == 1
                                 ? float(truth)
                                 : value + (float(truth) - value) * (weighted_ ? share_.inverse : 1.f);
        if (said != truth || value != 1) corrections_.push_back({i, weight - value, 1 / share_.inverse});
        weights_[i] = weight;
        weight == 0 ? clear_bit(answer.bits->row(0), i) : set_bit(answer.bits->row(0), i);
    }
    answer.weights = weights_;
    answer.corrections = corrections_;
    return answer;
}

}  // namespace viscache

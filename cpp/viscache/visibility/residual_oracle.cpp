#include "viscache/visibility/residual_oracle.h"

#include <cmath>

#include "viscache/sampling/point_key.h"
#include "viscache/visibility/local_samples.h"

namespace viscache {

ResidualOracle::ResidualOracle(std::unique_ptr<VisibilityOracle> inner, const RayCaster& caster, float extent,
                               double share, uint64_t seed, bool weighted)
    : inner_(std::move(inner)),
      exact_(caster, extent),
      seed_(seed),
      threshold_(uint64_t(std::clamp(std::floor(share * 0x1p32), 1.0, 0x1p32))),
      inverse_share_(weighted ? float(0x1p32 / double(threshold_)) : 1.f) {}

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

void ResidualOracle::block(const EyeBlock& eyes, const FarEnds& lights, const BitMatrix& wanted,
                           BitMatrix& visible, Counters& counters) {
    inner_->block(eyes, lights, wanted, visible, counters);
    drawn_.reset(wanted.rows(), lights.count);
    seen_.reset(wanted.rows(), lights.count);
    for (size_t i = 0; i < wanted.rows(); ++i) {
        if (i % 256 == 0) check_cancelled();
        const uint64_t key = eye_key(eyes, i, lights.group);
        for_each_bit(wanted.row_span(i), [&](size_t k) {
            if (is_drawn(key, k)) drawn_.set(i, k);
        });
    }
    Counters traced;
    exact_.block(eyes, lights, drawn_, seen_, traced);
    counters.group(lights.group).rays += traced.rays();
    counters.corrections += traced.rays();

    columns_ = lights.x.size();
    corrections_.clear();
    correction_begin_.assign(1, 0);
    for (size_t i = 0; i < wanted.rows(); ++i) {
        const std::span<const float> inner = inner_->block_weights(uint32_t(i));
        for_each_bit(drawn_.row_span(i), [&](size_t k) {
            const bool answer = visible.get(i, k), truth = seen_.get(i, k);
            counters.contradicted += answer != truth;
            const float value = !answer ? 0.f : inner.empty() ? 1.f : inner[k];
            const float weight = corrected(value, truth);
            // Without weights the bit is the full answer: a share of 1 gives the exact bits
            if (weight == 0) {
                clear_bit(visible.row(i), k);
            } else {
                visible.set(i, k);
                if (weight != 1 || !inner.empty()) corrections_.push_back({uint32_t(k), weight});
            }
        });
        correction_begin_.push_back(uint32_t(corrections_.size()));
    }
}

std::span<const float> ResidualOracle::block_weights(uint32_t eye) const {
    const std::span<const float> inner = inner_->block_weights(eye);
    const std::span<const Correction> own(corrections_.data() + correction_begin_[eye],
                                          correction_begin_[eye + 1] - correction_begin_[eye]);
    if (own.empty()) return inner;
    std::vector<float>& row = row_[next_row_++ % 2];
    if (inner.empty())
        row.assign(columns_, 1.f);
    else
        row.assign(inner.begin(), inner.end());
    for (const Correction& c : own) row[c.column] = c.weight;
    return row;
}

void ResidualOracle::pairs(const EyeBlock& eyes, std::span<const ShadowQuery> queries,
                           std::span<Word> visible, Counters& counters) {
    inner_->pairs(eyes, queries, visible, counters);
    correct(eyes, queries, visible, counters);
}

void ResidualOracle::samples(const EyeBlock& eyes, const LocalSamples& samples, std::span<Word> visible,
                             Counters& counters) {
    inner_->samples(eyes, samples, visible, counters);
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
    for (size_t d = 0; d < drawn.size(); ++d) {
        const uint32_t i = number[d];
        const bool answer = get_bit(visible.data(), i), truth = get_bit(seen.data(), d);
        counters.contradicted += answer != truth;
        const float weight = corrected(answer ? pair_weights_[i] : 0.f, truth);
        pair_weights_[i] = weight;
        weight == 0 ? clear_bit(visible.data(), i) : set_bit(visible.data(), i);
    }
}

}  // namespace viscache

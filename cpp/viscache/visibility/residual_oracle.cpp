#include "viscache/visibility/residual_oracle.h"

#include <cmath>

#include "viscache/sampling/point_key.h"
#include "viscache/visibility/local_samples.h"

namespace viscache {

namespace {

/// Few of the queries of one eye point are drawn, so that packets of one light would be nearly empty.
std::optional<PacketOrder> order_for(double share) {
    constexpr double kDense = 0.25;
    return share >= kDense ? std::nullopt : std::optional(PacketOrder::kByPixel);
}

}  // namespace

ResidualOracle::ResidualOracle(std::unique_ptr<VisibilityOracle> inner, const RayCaster& caster, float extent,
                               const ResidualSettings& s)
    : inner_(std::move(inner)),
      exact_(caster, extent, order_for(s.share.value_or(0))),
      share_(s.share),
      seed_(s.seed),
      lasting_seed_(s.lasting_seed),
      weighted_(s.weighted),
      threshold_(uint64_t(
          std::clamp(std::floor(s.share.value_or(ResidualSettings::kPlainShare) * 0x1p32), 1.0, 0x1p32))),
      inverse_share_(float(0x1p32 / double(threshold_))) {
    for (size_t b = 0; b < bands_below_.size(); ++b) bands_below_[b] = float(std::ldexp(s.certain, -int(b)));
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
void ResidualOracle::draw(const EyeBlock& eyes, const FarEnds& lights, const BitMatrix& wanted) {
    drawn_.reset(wanted.rows(), lights.count);
    halvings_.clear();
    if (by_contribution()) bands_.reset(ResidualSettings::kHalvings, lights.count);
    for (size_t i = 0; i < wanted.rows(); ++i) {
        if (i % 256 == 0) check_cancelled();
        if (by_contribution()) {
            draw_by_contribution(eyes, uint32_t(i), lights.group, wanted);
        } else {
            const uint64_t key = eye_key(eyes, i, lights.group);
            for_each_bit(wanted.row_span(i), [&](size_t k) {
                if (is_drawn(key, k)) drawn_.set(i, k);
            });
        }
    }
}

/// Draws 64 queries at once: each bound that lies above a query's contribution clears it with probability
/// one half. Samples of a pixel have the same random words in turns of 2^kHalvings, and the bits of a
/// sample's number say which half is cleared.
void ResidualOracle::draw_by_contribution(const EyeBlock& eyes, uint32_t eye, int group,
                                          const BitMatrix& wanted) {
    constexpr size_t kBands = ResidualSettings::kHalvings;
    const bool lasts = !eyes.place.empty();
    const uint32_t turn = lasts ? eyes.turn[eye] : 0;
    uint64_t key = eye_key(eyes, eye, group);
    if (lasts) key = Rng(lasting_seed_, Purpose::kResidual, eyes.place[eye], turn >> kBands).next_u64();
    key ^= mix64(uint64_t(group));
    std::array<Word*, kBands> below;
    for (size_t b = 0; b < kBands; ++b) below[b] = bands_.row(b);
    contributions_->at_most(eye, bands_below_, below);
    Word* drawn = drawn_.row(eye);
    for (size_t w = 0; w < words_for(wanted.columns()); ++w) {
        Word left = wanted.row(eye)[w];
        if (!left) continue;
        for (size_t b = 0; b < kBands; ++b)
            left &= ~below[b][w] | (mix64(key + (w * kBands + b) * 0x9E3779B97F4A7C15ull) ^
                                    (turn >> b & 1 ? ~Word{0} : Word{0}));
        drawn[w] = left;
    }
    for_each_bit(drawn_.row_span(eye), [&](size_t k) {
        uint8_t h = 0;
        for (size_t b = 0; b < kBands; ++b) h += get_bit(below[b], k);
        halvings_.push_back(h);
    });
}

void ResidualOracle::block(const EyeBlock& eyes, const FarEnds& lights, const BitMatrix& wanted,
                           BitMatrix& visible, Counters& counters) {
    corrections_.clear();
    correction_begin_.clear();
    replaces_ = false;
    inner_->block(eyes, lights, wanted, visible, counters);
    if (inner_->is_exact(lights)) return;
    draw(eyes, lights, wanted);
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
            const unsigned halvings = by_contribution() ? halvings_[number++] : 0;
            const bool answer = visible.get(i, k), truth = seen_.get(i, k);
            counters.contradicted += answer != truth;
            const float value = !answer ? 0.f : inner.empty() ? 1.f : inner[k];
            const float change = correction(value, truth, halvings);
            if (change == 0) return;
            // Without weights, a change by 1 is one of the bit: a share of 1 gives the exact frame
            if (inner.empty() && std::fabs(change) == 1)
                truth ? set_bit(visible.row(i), k) : clear_bit(visible.row(i), k);
            else
                corrections_.push_back({uint32_t(k), change});
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
        const std::span<const float> inner = inner_->pair_weights();
        pair_weights_.assign(inner.begin(), inner.end());
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
        if (inner_->is_exact_own(q.group) || !is_drawn(mix_point(eye_key(eyes, q.eye, q.group), q.far), 0))
            continue;
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
        const float value = answer ? pair_weights_[i] : 0.f;
        // At q = 1 this is the true visibility without rounding
        const float weight = inverse_share_ == 1
                                 ? float(truth)
                                 : value + (float(truth) - value) * (weighted_ ? inverse_share_ : 1.f);
        pair_weights_[i] = weight;
        weight == 0 ? clear_bit(visible.data(), i) : set_bit(visible.data(), i);
    }
}

}  // namespace viscache

#pragma once
// Any oracle as a control variate: V~ + (V - V~)/q for a random share q of the queries.
//
// The inner oracle answers all queries, with weights if it has them. A share q of the queries is also traced.
// If the ray contradicts the answer, the weight of the answer is corrected. So the frame is unbiased for any
// inner oracle whose answers do not depend on the random choice.
#include <memory>

#include "viscache/visibility/exact.h"

namespace viscache {

class ResidualOracle final : public VisibilityOracle {
public:
    /// `share` is in (0, 1]. Without `weighted`, a corrected answer counts as if q were 1. This is biased on
    /// purpose, for tests that must detect it.
    ResidualOracle(std::unique_ptr<VisibilityOracle> inner, const RayCaster& caster, float extent,
                   double share, uint64_t seed, bool weighted = true);

    VisibilityOracle& inner() { return *inner_; }

    void watch(const Control& control) override;
    void weigh(const Contributions* contributions) override { inner_->weigh(contributions); }
    void begin_tile(const EyeBlock& eyes) override;
    void block(const EyeBlock& eyes, const FarEnds& lights, const BitMatrix& wanted, BitMatrix& visible,
               Counters& counters) override;
    PairOrder pair_order(const EyeBlock& eyes) override { return inner_->pair_order(eyes); }
    void pairs(const EyeBlock& eyes, std::span<const ShadowQuery> queries, std::span<Word> visible,
               Counters& counters) override;
    std::span<const float> block_weights(uint32_t eye) const override;
    std::span<const float> pair_weights() const override { return pair_weights_; }
    PairOrder sample_order(const EyeBlock& eyes, int group) override {
        return inner_->sample_order(eyes, group);
    }
    void samples(const EyeBlock& eyes, const LocalSamples& samples, std::span<Word> visible,
                 Counters& counters) override;

private:
    bool is_drawn(uint64_t key, uint64_t number) const;
    uint64_t eye_key(const EyeBlock& eyes, size_t eye, int group) const;
    /// The weight of an answer: the value of the inner oracle, moved towards the true visibility by 1/q. For
    /// q = 1 this is the true visibility without rounding.
    float corrected(float value, bool truth) const {
        return inverse_share_ == 1 ? float(truth) : value + (float(truth) - value) * inverse_share_;
    }
    void correct(const EyeBlock& eyes, std::span<const ShadowQuery> queries, std::span<Word> visible,
                 Counters& counters);

    std::unique_ptr<VisibilityOracle> inner_;
    ExactOracle exact_;
    uint64_t seed_;
    uint64_t threshold_;  ///< a query is drawn if its 32 random bits are below this
    float inverse_share_;
    // For `block`: answers that the ray contradicts or whose weight changes
    struct Correction {
        uint32_t column;
        float weight;
    };
    BitMatrix drawn_, seen_;
    std::vector<uint32_t> correction_begin_;
    std::vector<Correction> corrections_;
    /// Buffers for rows of weights. Consecutive rows have different addresses.
    mutable std::vector<float> row_[2];
    mutable unsigned next_row_ = 0;
    size_t columns_ = 0;
    // For `pairs` and `samples`
    std::vector<float> pair_weights_;
};

}  // namespace viscache

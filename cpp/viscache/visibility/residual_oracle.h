#pragma once
// Any oracle as a control variate: V~ + (V - V~)/q for a random share q of the queries.
//
// The inner oracle answers everything, with its weights if it has some. A share q of the queries is traced as
// well, and where the ray contradicts, the weight of the answer carries the correction. So the frame is right
// in expectation whatever the inner oracle says, as long as its answer does not depend on the draw.
#include <memory>

#include "viscache/visibility/exact.h"

namespace viscache {

class ResidualOracle final : public VisibilityOracle {
public:
    /// `share` in (0, 1]. Without `weighted`, a corrected answer counts as if q were 1, which is wrong: for
    /// tests that must notice.
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
    /// The weight of an answer: the inner oracle's value moved towards the truth by 1/q.
    /// At q = 1 that is the truth, without rounding.
    float corrected(float value, bool truth) const {
        return inverse_share_ == 1 ? float(truth) : value + (float(truth) - value) * inverse_share_;
    }
    void correct(const EyeBlock& eyes, std::span<const ShadowQuery> queries, std::span<Word> visible,
                 Counters& counters);

    std::unique_ptr<VisibilityOracle> inner_;
    ExactOracle exact_;
    uint64_t seed_;
    uint64_t threshold_;  ///< a number of 32 random bits is drawn if it is smaller
    float inverse_share_;
    // Of `block`: answers that the inner oracle and the ray disagree on
    struct Correction {
        uint32_t column;
        float weight;
    };
    BitMatrix drawn_, seen_;
    std::vector<uint32_t> correction_begin_;
    std::vector<Correction> corrections_;
    /// Room for rows of weights; whoever looks at one row after another sees another address each time.
    mutable std::vector<float> row_[2];
    mutable unsigned next_row_ = 0;
    size_t columns_ = 0;
    // Of `pairs` and `samples`
    std::vector<float> pair_weights_;
};

}  // namespace viscache

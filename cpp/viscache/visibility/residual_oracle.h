#pragma once
// Any oracle as a control variate: V~ + (V - V~)/q for a random share q of the queries.
//
// The inner oracle answers all queries, with weights if it has them. A share q of the queries is also traced.
// If the ray contradicts the answer, its weight is corrected. So the frame is unbiased for any inner oracle
// whose answers do not depend on the random choice. Lights that the inner oracle answers exactly need no
// correction and get none.
//
// q is the same for all queries, or follows the unoccluded contribution c of a connection. By contribution, q
// is 1 where c is `certain` of a reference (reference_light.h), and halves with each halving of c, at most
// kHalvings times. Where the reference is not known it is the light that all queries of the eye point could
// bring.
// Then no correction weighs much more than another: the variance of a wrong bit is c²(1 − q)/q.
// The best share is proportional to c·√p, where p is the probability that the answer is wrong. Classes of
// answers differ in p (counters.h). Each may have its own bound, `certain` times a power of two.
#include <array>
#include <memory>
#include <optional>

#include "viscache/visibility/draw_kernels.h"
#include "viscache/visibility/exact.h"

namespace viscache {

/// By light group and class of answers: where the share of corrections reaches 1, as a power of two.
using ClassOctaves = std::array<std::array<uint8_t, kAnswerClasses>, kLightGroups>;
constexpr uint8_t kPlainOctave = 1;
constexpr ClassOctaves plain_octaves() {
    ClassOctaves octaves{};
    for (auto& group : octaves) group.fill(kPlainOctave);
    return octaves;
}

struct ResidualSettings {
    /// q in (0, 1]; empty: by contribution. Connections without known contributions are then drawn with
    /// kPlainShare.
    std::optional<double> share;
    /// By contribution: above this share of the reference, q is 1.
    double certain = 1.0 / 32;
    uint64_t seed = 0;
    /// By contribution: q of a class reaches 1 at certain·2^(octave − kPlainOctave). Octaves are at most
    /// kMostOctaves, and must not depend on the draws of this frame.
    ClassOctaves octaves = plain_octaves();
    /// By contribution in frames: the seed of all frames that go on from each other. A query with q = 2^−h is
    /// drawn in one of 2^h samples of its pixel that follow each other, at a random place among them. So many
    /// samples together miss few wrong answers.
    uint64_t lasting_seed = 0;
    /// Without weights, a corrected answer counts as if q were 1. This is biased on purpose, for tests that
    /// must detect it.
    bool weighted = true;
    static constexpr double kPlainShare = 0.1;
    static constexpr size_t kHalvings = kMostHalvings;
};

class ResidualOracle final : public VisibilityOracle {
public:
    ResidualOracle(std::unique_ptr<VisibilityOracle> inner, const RayCaster& caster, float extent,
                   const ResidualSettings& settings);

    VisibilityOracle& inner() { return *inner_; }

    void watch(const Control& control) override;
    void weigh(const Contributions* contributions) override {
        contributions_ = contributions;
        inner_->weigh(contributions);
    }
    void begin_tile(const EyeBlock& eyes) override;
    void block(const EyeBlock& eyes, const FarEnds& lights, const BitMatrix& wanted, BitMatrix& visible,
               Counters& counters) override;
    PairOrder pair_order(const EyeBlock& eyes) override { return inner_->pair_order(eyes); }
    void pairs(const EyeBlock& eyes, std::span<const ShadowQuery> queries, std::span<Word> visible,
               Counters& counters) override;
    std::span<const float> block_weights(uint32_t eye) const override {
        if (replaces_) return {};
        return inner_->block_weights(eye);
    }
    std::span<const Correction> block_corrections(uint32_t eye) const override {
        if (correction_begin_.empty()) return {};
        return std::span(corrections_)
            .subspan(correction_begin_[eye], correction_begin_[eye + 1] - correction_begin_[eye]);
    }
    bool is_exact(const FarEnds& lights) const override { return inner_->is_exact(lights); }
    bool is_exact_own(int group) const override { return inner_->is_exact_own(group); }
    std::span<const float> pair_weights() const override { return pair_weights_; }
    std::span<const Correction> pair_corrections() const override { return pair_corrections_; }
    PairOrder sample_order(const EyeBlock& eyes, int group) override {
        return inner_->sample_order(eyes, group);
    }
    void samples(const EyeBlock& eyes, const LocalSamples& samples, std::span<Word> visible,
                 Counters& counters) override;

private:
    bool by_contribution() const { return !share_ && contributions_; }
    bool is_drawn(uint64_t key, uint64_t number) const;
    uint64_t eye_key(const EyeBlock& eyes, size_t eye, int group) const;
    void draw(const EyeBlock& eyes, const FarEnds& lights, const BitMatrix& wanted, const BitMatrix& visible,
              Counters& counters);
    void draw_by_contribution(const EyeBlock& eyes, uint32_t eye, int group, const BitMatrix& wanted,
                              const BitMatrix& visible, Counters& counters);
    /// What to add to an answer of `value` if the truth is `truth`.
    float correction(float value, bool truth, unsigned halvings) const {
        const float inverse = by_contribution() ? std::ldexp(1.f, int(halvings)) : inverse_share_;
        return (float(truth) - value) * (weighted_ ? inverse : 1.f);
    }
    float share_of(unsigned halvings) const {
        return by_contribution() ? std::ldexp(1.f, -int(halvings)) : 1 / inverse_share_;
    }
    void correct(const EyeBlock& eyes, std::span<const ShadowQuery> queries, std::span<Word> visible,
                 Counters& counters);

    std::unique_ptr<VisibilityOracle> inner_;
    ExactOracle exact_;
    std::optional<double> share_;
    /// Bounds of contributions, falling by halves. A connection of a class of octave 0 that lies below h of
    /// the last kHalvings is drawn with q = 2^−h. Each octave counts bounds from one further above.
    std::array<float, kMostOctaves + ResidualSettings::kHalvings> bounds_;
    ClassOctaves octaves_;
    uint64_t seed_, lasting_seed_;
    bool weighted_;
    uint64_t threshold_;  ///< a query is drawn if its 32 random bits are below this
    float inverse_share_;
    const Contributions* contributions_ = nullptr;
    const DrawKernels& kernels_ = draw_kernels(active_isa());
    // For `block`
    bool replaces_ = false;  ///< every answer is replaced by the truth, so that none has a weight
    BitMatrix drawn_, seen_;
    BitMatrix masks_;  ///< rows of one eye point: below each bound, below bound h of its class, and two more
    struct Drawn {
        uint8_t halvings, answer_class;
    };
    std::vector<Drawn> drawn_as_;             ///< by contribution: of each drawn query, in their order
    std::vector<uint32_t> correction_begin_;  ///< by eye point
    std::vector<Correction> corrections_;
    // For `pairs` and `samples`
    std::vector<float> pair_weights_;
    std::vector<Correction> pair_corrections_;
};

}  // namespace viscache

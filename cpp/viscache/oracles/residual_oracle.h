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
// bring. Then no correction weighs much more than another: the variance of a wrong bit is c²(1 − q)/q.
//
// How a query gets its q (draw_by_contribution). Bounds fall by halves, and each has a mask of random bits
// that clears half of the queries below it. A query below h bounds must pass h masks, so its q is 2^−h:
//
//     contribution     large ◄───────────────────────► small
//     bounds                  B0      B1      B2      B3
//     query                a  │   b   │   c   │   d   │  e
//     mask of B0              │  1/2     1/2     1/2     1/2
//     mask of B1              │       │  1/2     1/2     1/2
//     mask of B2              │       │       │  1/2     1/2
//     mask of B3              │       │       │       │  1/2
//     q                    1  │  1/2  │  1/4  │  1/8  │  1/16
//
// Masks are words of 64 columns, so all queries of an eye point are drawn at once. In samples of a pixel that
// follow each other, a mask and its complement take turns: of 2^h samples exactly one draws the query.
//
// The best share is proportional to c·√p, where p is the probability that the answer is wrong. Classes of
// answers differ in p (counters.h). A class of octave o has its own B0, 2^o times that of octave 0, and as
// many bounds below it. All classes share one list of bounds and begin at their own place in it.
#include <array>
#include <memory>
#include <optional>

#include "viscache/oracles/draw_kernels.h"
#include "viscache/oracles/exact.h"
#include "viscache/oracles/random_share.h"

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
    ResidualOracle(std::unique_ptr<VisibilityOracle> inner, const RayCaster& caster,
                   const ResidualSettings& settings);

    VisibilityOracle& inner() { return *inner_; }

    void begin_tile(const EyeBlock& eyes) override;
    PairOrder order(const EyeBlock& eyes, std::optional<int> group) override {
        return inner_->order(eyes, group);
    }
    Answer block(const BlockAsk& ask, Counters& counters) override;
    Answer pairs(const PairsAsk& ask, Counters& counters) override;

private:
    static constexpr size_t kBounds = kMostOctaves + ResidualSettings::kHalvings;
    /// A drawn query: 1/q, and the class of its answer.
    struct Drawn {
        float inverse_share;
        uint8_t answer_class;
    };
    void draw_evenly(const BlockAsk& ask, uint32_t eye);
    void draw_by_contribution(const BlockAsk& ask, const Answer& inner, uint32_t eye, Counters& counters);
    void correct(const BlockAsk& ask, const BitMatrix& seen, bool by_contribution, Answer& answer,
                 Counters& counters);

    std::unique_ptr<VisibilityOracle> inner_;
    ExactOracle exact_;
    bool has_share_;
    RandomShare share_;  ///< of all queries, or of those without known contributions
    /// Bounds of contributions, falling by halves. A class of octave o counts the kHalvings bounds from
    /// number kMostOctaves − o on.
    std::array<float, kBounds> bounds_;
    ClassOctaves octaves_;
    EyeKeys keys_;
    bool weighted_;
    const DrawKernels& kernels_ = draw_kernels(active_isa());
    // For `block`
    BitMatrix drawn_;
    std::vector<Drawn> drawn_as_;  ///< each drawn query, in their order
    // Columns of one eye point: row b lies below bound b; row h has more than h halvings of q; a neighbouring
    // light has the other answer; a row of zeros
    BitMatrix below_bound_, halved_, differs_, none_;
    std::vector<uint32_t> correction_begin_;  ///< by eye point
    std::vector<Correction> corrections_;
    // For `pairs`
    std::vector<float> weights_;
};

}  // namespace viscache

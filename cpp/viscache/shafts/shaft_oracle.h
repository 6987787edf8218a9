#pragma once
// Exact visibility of many eye points and shared points, by shafts.
#include <memory>
#include <mutex>

#include "viscache/shafts/shaft_kernels.h"
#include "viscache/shafts/shaft_scene.h"
#include "viscache/visibility/oracle.h"
#include "viscache/visibility/ray_caster.h"

namespace viscache {

/// What shafts and rays did in a frame; its oracles add to it.
class ShaftTotals {
public:
    struct Sums {
        uint64_t queries = 0;          ///< queries that shafts answered
        uint64_t left_to_packets = 0;  ///< other queries to shared points
        ShaftCounts work;
    };
    void add(const Sums& more);
    Sums sums() const;

private:
    mutable std::mutex mutex_;
    Sums sums_;
};

/// How shafts are used.
struct ShaftOptions {
    /// Leave a tile to packets where they cost less: few lights, or by the work of the first 64
    /// (shaft_choice.h).
    bool choose = false;
    /// Factor of all error bounds. Below 1, answers may differ from those of rays; for tests.
    float bounds = 1;
    Isa isa = active_isa();
};

/// The answers of an exact oracle bit for bit. Blocks of shared points and surfaces go through shafts, all
/// else to the exact oracle. The caster must be Embree's with robust rays.
class ShaftOracle final : public VisibilityOracle {
public:
    /// All references must outlive the oracle.
    ShaftOracle(const ShaftScene& scene, const RayCaster& caster, std::unique_ptr<VisibilityOracle> exact,
                const ShaftOptions& options, ShaftTotals& totals)
        : scene_(scene), caster_(caster), exact_(std::move(exact)), options_(options), totals_(totals) {
        wrap(*exact_);
    }

    void begin_tile(const EyeBlock& eyes) override;
    Answer block(const BlockAsk& ask, Counters& counters) override;
    Answer pairs(const PairsAsk& ask, Counters& counters) override {
        return exact(exact_->pairs(ask, counters));
    }

private:
    /// Everything that this oracle says counts as exact, whichever engine answered.
    static Answer exact(Answer answer) {
        answer.exact.set();
        return answer;
    }
    bool fits(const EyeBlock& eyes, const FarEnds& lights);
    void prepare(const EyeBlock& eyes);
    bool is_sorted(const EyeBlock& eyes) const { return is_prepared_ && order_.size() == eyes.size(); }
    void answer_word(size_t w, Word some, const EyeBlock& eyes, const FarEnds& lights);

    const ShaftScene& scene_;
    const RayCaster& caster_;
    std::unique_ptr<VisibilityOracle> exact_;
    ShaftOptions options_;
    ShaftTotals& totals_;
    // Of the tile
    bool is_prepared_ = false, eyes_fit_ = false;
    std::vector<uint32_t> order_;
    ShaftEyes eyes_;
    // Of a block
    BitMatrix wanted_, visible_, rest_;  ///< the first two in the order of the shafts
    ShaftColumns columns_;
    ShaftMemory memory_;
};

}  // namespace viscache

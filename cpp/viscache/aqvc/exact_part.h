#pragma once
// The light groups of a quantized cache that an exact oracle answers.
#include <memory>
#include <vector>

#include "viscache/aqvc/parameters.h"
#include "viscache/visibility/oracle.h"

namespace viscache {

/// Who answers the exact groups, and lights of the frame that all eye points share, of which a small part is
/// exact.
struct ExactAnswers {
    std::unique_ptr<VisibilityOracle> oracle;
    size_t shared_in_frame = 0;
    size_t few = kFewLights;  ///< groups of at most so many shared lights are exact unless others are named
};

class ExactPart {
public:
    /// With a table of the frame no group is exact unless it is named: its connections are to fill the table.
    ExactPart(ExactAnswers answers, const AqvcParameters& parameters, bool of_frame)
        : answers_(std::move(answers)), parameters_(parameters) {
        // Bidirectional connections are different for every path, so there are no shared lights to make
        // exact.
        const bool none = of_frame && !parameters.exact_groups;
        for (int g = 0; g < kLightGroups; ++g)
            own_.set(size_t(g), !none && answers_own_exactly(parameters, g));
    }

    /// True if it answers connections with these lights.
    bool answers(const FarEnds& lights) const {
        return answers_exactly(parameters_, lights.group, lights.count, answers_.shared_in_frame,
                               answers_.few);
    }
    /// The light groups whose far ends of single eye points it answers.
    LightGroupSet own() const { return own_; }
    VisibilityOracle& oracle() { return *answers_.oracle; }

    /// Sets the bits of the queries of exact groups, and hands the others to `rest(queries, visible)`.
    template <class Rest>
    void pairs(const EyeBlock& eyes, std::span<const ShadowQuery> queries, std::span<Word> visible,
               Counters& counters, Rest rest) {
        numbers_[0].clear();
        numbers_[1].clear();
        if (own_.any())
            for (size_t i = 0; i < queries.size(); ++i)
                numbers_[own_.test(queries[i].group)].push_back(uint32_t(i));
        // Mostly all queries go one way and need no copies.
        if (numbers_[1].empty()) return rest(queries, visible);
        if (numbers_[0].empty()) {
            std::ranges::copy(oracle().pairs({eyes, queries}, counters).row(0), visible.begin());
            return;
        }
        // Both halves use the same buffers, one after the other.
        for (const bool exact : {false, true}) {
            some_.clear();
            for (uint32_t i : numbers_[exact]) some_.push_back(queries[i]);
            answer_.assign(words_for(some_.size()), 0);
            if (!exact) rest(std::span<const ShadowQuery>(some_), std::span<Word>(answer_));
            const std::span<const Word> seen =
                exact ? oracle().pairs({eyes, some_}, counters).row(0) : std::span<Word>(answer_);
            for_each_bit(seen, [&](size_t k) { set_bit(visible.data(), numbers_[exact][k]); });
        }
    }

private:
    ExactAnswers answers_;
    const AqvcParameters& parameters_;
    LightGroupSet own_;
    // Of a call of `pairs`: numbers of the cached and of the exact queries, the queries of one of them,
    // answers
    std::array<std::vector<uint32_t>, 2> numbers_;
    std::vector<ShadowQuery> some_;
    std::vector<Word> answer_;
};

}  // namespace viscache

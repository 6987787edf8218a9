#pragma once
// Finds the fastest of several ways to trace the current packets, by timing. All ways give the same answers,
// but for one in 10⁹ that Embree's flags round differently (docs/performance/exact.md).
#include <cstddef>
#include <ctime>
#include <optional>
#include <vector>

#include "viscache/visibility/ray_caster.h"

namespace viscache {

/// CPU seconds of the calling thread.
inline double thread_cpu_seconds() {
    timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return double(t.tv_sec) + 1e-9 * double(t.tv_nsec);
}

/// One object per thread and kind of work. Work is done in pieces of at least some hundred rays. From time
/// to time the choices take turns for a few pieces; the fastest one is then used until the next trial.
template <class Choice>
class Trial {
public:
    /// `fixed`: always use this choice, without trials. `period`: number of pieces from one trial to the
    /// next.
    Trial(std::vector<Choice> choices, std::optional<Choice> fixed, size_t period)
        : choices_(std::move(choices)), fixed_(fixed), period_(period), spent_(choices_.size()) {}

    /// Runs work(choice) as the next piece; it returns the number of rays that it traced.
    template <class Work>
    void piece(Work work) {
        const size_t turn = pieces_++ % period_;
        if (fixed_ || turn >= kTurns) {
            work(fixed_.value_or(choices_[best_]));
            return;
        }
        if (turn == 0) spent_.assign(choices_.size(), {});
        const double before = thread_cpu_seconds();
        Spent& spent = spent_[turn % choices_.size()];
        spent.rays += work(choices_[turn % choices_.size()]);
        spent.seconds += thread_cpu_seconds() - before;
        if (turn + 1 == kTurns) take_best();
    }

private:
    static constexpr size_t kTurns = 8;
    struct Spent {
        double seconds = 0;
        size_t rays = 0;
    };
    /// Takes the choice with the fewest seconds per ray. Keeps the previous one if a choice had no rays to
    /// trace.
    void take_best() {
        size_t best = 0;
        for (size_t i = 0; i < spent_.size(); ++i) {
            if (spent_[i].rays == 0) return;
            if (spent_[i].seconds * double(spent_[best].rays) < spent_[best].seconds * double(spent_[i].rays))
                best = i;
        }
        best_ = best;
    }
    std::vector<Choice> choices_;
    std::optional<Choice> fixed_;
    size_t period_;
    size_t best_ = 0, pieces_ = 0;
    std::vector<Spent> spent_;
};

/// A trial of Embree's traversal flags.
class CoherenceTrial : public Trial<Coherence> {
public:
    explicit CoherenceTrial(std::optional<Coherence> fixed, size_t period = 512)
        : Trial({Coherence::kCoherent, Coherence::kIncoherent}, fixed, period) {}
};

}  // namespace viscache

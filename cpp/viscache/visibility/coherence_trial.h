#pragma once
// Which of two ways to trace is faster for the packets at hand, found by timing. Speed only: both give the
// same answers.
#include <array>
#include <cstddef>
#include <ctime>
#include <optional>

#include "viscache/visibility/ray_caster.h"

namespace viscache {

/// CPU seconds of the calling thread.
inline double thread_cpu_seconds() {
    timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return double(t.tv_sec) + 1e-9 * double(t.tv_nsec);
}

/// One object per thread and kind of work. Work is done in pieces of some hundred rays or more; at times the
/// two choices take turns for a few pieces, and the faster one serves until the next turn.
template <class Choice>
class Trial {
public:
    /// `fixed`: always this choice, no trial. `period`: pieces from one trial to the next.
    Trial(std::array<Choice, 2> choices, std::optional<Choice> fixed, size_t period)
        : choices_(choices), fixed_(fixed), period_(period) {}

    /// Runs work(choice) → number of rays it traced, as the next piece.
    template <class Work>
    void piece(Work work) {
        const size_t turn = pieces_++ % period_;
        if (fixed_ || turn >= kTurns) {
            work(fixed_.value_or(choices_[best_]));
            return;
        }
        if (turn == 0) seconds_ = {}, rays_ = {};
        const double before = thread_cpu_seconds();
        const size_t rays = work(choices_[turn % 2]);
        seconds_[turn % 2] += thread_cpu_seconds() - before, rays_[turn % 2] += rays;
        if (turn + 1 == kTurns && rays_[0] > 0 && rays_[1] > 0)
            best_ = seconds_[0] * double(rays_[1]) <= seconds_[1] * double(rays_[0]) ? 0 : 1;
    }

private:
    static constexpr size_t kTurns = 8;
    std::array<Choice, 2> choices_;
    std::optional<Choice> fixed_;
    size_t period_;
    size_t best_ = 0, pieces_ = 0;
    std::array<double, 2> seconds_{};
    std::array<size_t, 2> rays_{};
};

/// Of Embree's traversal flags.
class CoherenceTrial : public Trial<Coherence> {
public:
    explicit CoherenceTrial(std::optional<Coherence> fixed, size_t period = 512)
        : Trial({Coherence::kCoherent, Coherence::kIncoherent}, fixed, period) {}
};

}  // namespace viscache

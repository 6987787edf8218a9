#pragma once
// Which of Embree's traversal flags is faster for the packets at hand, found by timing. Speed only: every
// flag gives the same answers.
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

/// One object per thread and kind of packets. Work is done in pieces of some hundred rays or more; at times
/// the flags take turns for a few pieces, and the faster one serves until the next turn.
class CoherenceTrial {
public:
    /// `fixed`: always this flag, no trial. `period`: pieces from one trial to the next.
    explicit CoherenceTrial(std::optional<Coherence> fixed, size_t period = 512)
        : fixed_(fixed), period_(period) {}

    /// Runs work(flag) → number of rays it traced, as the next piece.
    template <class Work>
    void piece(Work work) {
        const size_t turn = pieces_++ % period_;
        if (fixed_ || turn >= kTurns) {
            work(fixed_.value_or(best_));
            return;
        }
        if (turn == 0) seconds_ = {}, rays_ = {};
        const double before = thread_cpu_seconds();
        const size_t rays = work(turn % 2 ? Coherence::kIncoherent : Coherence::kCoherent);
        seconds_[turn % 2] += thread_cpu_seconds() - before, rays_[turn % 2] += rays;
        if (turn + 1 == kTurns && rays_[0] > 0 && rays_[1] > 0)
            best_ = seconds_[0] * double(rays_[1]) <= seconds_[1] * double(rays_[0]) ? Coherence::kCoherent
                                                                                     : Coherence::kIncoherent;
    }

private:
    static constexpr size_t kTurns = 8;
    std::optional<Coherence> fixed_;
    size_t period_;
    Coherence best_ = Coherence::kCoherent;
    size_t pieces_ = 0;
    std::array<double, 2> seconds_{};
    std::array<size_t, 2> rays_{};
};

}  // namespace viscache

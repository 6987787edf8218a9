#pragma once
// Time of a frame's stages.
#include <chrono>

#include "viscache/visibility/coherence_trial.h"

namespace viscache {

inline double wall_seconds() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// Adds the CPU time since the last call to one stage after another.
class StageClock {
public:
    void skip() { last_ = thread_cpu_seconds(); }
    void lap(double& stage) {
        const double now = thread_cpu_seconds();
        stage += now - last_;
        last_ = now;
    }

private:
    double last_ = thread_cpu_seconds();
};

}  // namespace viscache

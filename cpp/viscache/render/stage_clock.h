#pragma once
// CPU time of a frame's stages.
#include "viscache/math/cpu_time.h"

namespace viscache {

/// CPU seconds of the stages, summed over threads.
struct StageSeconds {
    double eye_paths = 0, contributions = 0, visibility = 0, shading = 0, audit = 0;
    void merge(const StageSeconds& b) {
        eye_paths += b.eye_paths;
        contributions += b.contributions;
        visibility += b.visibility;
        shading += b.shading;
        audit += b.audit;
    }
};

/// Measures stages that follow each other: `lap` adds the CPU time since the last call to a stage.
class StageClock {
public:
    // CPU time of the thread: waiting for other threads is no cost of a stage
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

#pragma once
// CPU time of threads.
#include <ctime>

namespace viscache {

/// CPU seconds of the calling thread.
inline double thread_cpu_seconds() {
    timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return double(t.tv_sec) + 1e-9 * double(t.tv_nsec);
}

}  // namespace viscache

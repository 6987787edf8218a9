#pragma once
// Parallel loops. Threads take chunks from a shared counter, so results must not depend on which thread ran
// a chunk.
#include <sched.h>

#include <atomic>
#include <cstddef>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace viscache {

/// Thrown inside a long call after `Control::cancel` is set. The caller reports it as an interruption.
class Cancelled : public std::exception {
public:
    const char* what() const noexcept override { return "cancelled"; }
};

/// Progress and cancellation of a long call. All members may be used from any thread.
struct Control {
    std::atomic<bool> cancel{false};
    std::atomic<uint64_t> done{0}, total{0};

    void check() const {
        if (cancel.load(std::memory_order_relaxed)) throw Cancelled();
    }
};

/// The cores that this process may use, as Python's os.sched_getaffinity counts them.
inline int hardware_threads() {
    cpu_set_t cores;
    const bool known = sched_getaffinity(0, sizeof cores, &cores) == 0;
    return std::max(1, known ? CPU_COUNT(&cores) : int(std::thread::hardware_concurrency()));
}

/// Number of threads to use: `wish`, or all hardware threads when `wish` is 0 or less.
inline int resolve_threads(int wish) { return wish > 0 ? wish : hardware_threads(); }

/// Calls work(chunk, worker) for every chunk in [0, chunks). `worker` < threads identifies the thread. After
/// the first exception no more chunks start; the exception is rethrown here.
template <class Work>
void parallel_for(size_t chunks, int threads, Work work) {
    // No more threads than chunks
    threads = int(std::min<size_t>(size_t(resolve_threads(threads)), std::max<size_t>(1, chunks)));
    std::atomic<size_t> next{0};
    std::exception_ptr error;
    std::mutex error_mutex;
    auto run = [&](int worker) {
        try {
            // Chunks differ in cost, so threads take the next one when they are done.
            for (size_t c; (c = next.fetch_add(1)) < chunks;) work(c, worker);
        } catch (...) {
            // No further chunks are given out; those that run come to their own end.
            next.store(chunks);
            const std::lock_guard lock(error_mutex);
            if (!error) error = std::current_exception();
        }
    };
    std::vector<std::thread> helpers;
    for (int w = 1; w < threads; ++w) helpers.emplace_back(run, w);
    // The calling thread works, too.
    run(0);
    for (std::thread& t : helpers) t.join();
    if (error) std::rethrow_exception(error);
}

}  // namespace viscache

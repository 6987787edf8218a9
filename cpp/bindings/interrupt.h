#pragma once
// Long calls: they release the GIL, and handle Ctrl-C and progress twenty times per second.
#include <pybind11/pybind11.h>

#include <condition_variable>
#include <exception>
#include <mutex>
#include <optional>
#include <thread>

#include "gil.h"
#include "viscache/math/parallel.h"

namespace viscache::bindings {

/// Runs work(Control&) on another thread, while this thread handles signals and calls `progress(done, total)`
/// unless it is None. If one of them throws, the work is cancelled, and the exception is rethrown after it
/// has ended. If the interpreter ends, the work of its other threads is cancelled and they get SystemExit.
/// Returns what the work returns.
template <class Work>
auto run_interruptible(Work work, const pybind11::object& progress = pybind11::none()) {
    namespace py = pybind11;
    using Result = std::invoke_result_t<Work, Control&>;
    [[maybe_unused]] std::conditional_t<std::is_void_v<Result>, bool, std::optional<Result>> result{};
    Control control;
    std::mutex mutex;
    std::condition_variable finished;
    bool done = false;
    std::exception_ptr error;
    std::exception_ptr python_error;
    {
        const WithoutGil release;
        // The work has a thread of its own, so that this one can look for Ctrl-C in between.
        std::thread worker([&] {
            try {
                if constexpr (std::is_void_v<Result>)
                    work(control);
                else
                    result.emplace(work(control));
            } catch (...) {
                error = std::current_exception();
            }
            const std::lock_guard lock(mutex);
            done = true;
            finished.notify_one();
        });
        std::unique_lock lock(mutex);
        while (!finished.wait_for(lock, std::chrono::milliseconds(50), [&] { return done; })) {
            // Not held during Python code: the worker must be able to say that it is done.
            lock.unlock();
            if (must_stop()) control.cancel = true;
            if (!control.cancel) {
                with_python([&] {
                    try {
                        if (PyErr_CheckSignals() != 0) throw py::error_already_set();
                        if (!progress.is_none()) progress(control.done.load(), control.total.load());
                    } catch (abi::__forced_unwind&) {
                        // CPython's way to kill this thread: not an error, and not to be caught.
                        throw;
                    } catch (...) {
                        // Kept until the worker has ended; the exception must not leave while it still uses
                        // the arguments.
                        python_error = std::current_exception();
                        control.cancel = true;
                    }
                });
            }
            lock.lock();
        }
        lock.unlock();
        worker.join();
    }
    // What Python raised comes first: the work's own `Cancelled` is only its consequence.
    if (python_error) std::rethrow_exception(python_error);
    // The interpreter ends: its threads leave silently.
    if (error && must_stop()) leave_thread();
    if (error) std::rethrow_exception(error);
    // The last call says "all", whatever the last tick saw.
    if (!progress.is_none() && control.total > 0) progress(control.total.load(), control.total.load());
    if constexpr (!std::is_void_v<Result>) return *std::move(result);
}

}  // namespace viscache::bindings

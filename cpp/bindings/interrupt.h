#pragma once
// Long calls: they release the GIL, and handle Ctrl-C and progress twenty times per second.
#include <pybind11/pybind11.h>

#include <condition_variable>
#include <exception>
#include <mutex>
#include <thread>

#include "gil.h"
#include "viscache/math/parallel.h"

namespace viscache::bindings {

/// Runs work(Control&) on another thread, while this thread handles signals and calls `progress(done, total)`
/// unless it is None. If one of them throws, the work is cancelled, and the exception is rethrown after it
/// has ended. If the interpreter ends, the work of its other threads is cancelled and they get SystemExit.
template <class Work>
void run_interruptible(Work work, const pybind11::object& progress = pybind11::none()) {
    namespace py = pybind11;
    Control control;
    std::mutex mutex;
    std::condition_variable finished;
    bool done = false;
    std::exception_ptr error;
    std::exception_ptr python_error;
    {
        const WithoutGil release;
        std::thread worker([&] {
            try {
                work(control);
            } catch (...) {
                error = std::current_exception();
            }
            const std::lock_guard lock(mutex);
            done = true;
            finished.notify_one();
        });
        std::unique_lock lock(mutex);
        while (!finished.wait_for(lock, std::chrono::milliseconds(50), [&] { return done; })) {
            lock.unlock();
            if (must_stop()) control.cancel = true;
            if (!control.cancel) {
                with_python([&] {
                    try {
                        if (PyErr_CheckSignals() != 0) throw py::error_already_set();
                        if (!progress.is_none()) progress(control.done.load(), control.total.load());
                    } catch (abi::__forced_unwind&) {
                        throw;
                    } catch (...) {
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
    if (python_error) std::rethrow_exception(python_error);
    if (error && must_stop()) leave_thread();
    if (error) std::rethrow_exception(error);
    if (!progress.is_none() && control.total > 0) progress(control.total.load(), control.total.load());
}

}  // namespace viscache::bindings

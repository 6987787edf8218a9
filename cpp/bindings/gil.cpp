#include "gil.h"

#include <pthread.h>
#include <unistd.h>

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <thread>

namespace py = pybind11;

namespace viscache::bindings {

namespace {

using namespace std::chrono_literals;
constexpr auto kPatience = 5s;  // for calls that do not end; a cancelled one takes half a second
// Short enough for Ctrl-C, long enough to cost nothing
constexpr auto kTick = 50ms;

}  // namespace

/// The threads that are out of Python, in a call.
struct Threads {
    std::mutex mutex;
    std::condition_variable fewer;
    std::optional<std::thread::id> last;  ///< the thread that ends the interpreter
    bool closed = false;                  ///< nobody but it may ask for the lock
    size_t outside = 0;                   ///< threads in calls without the lock
    size_t asking = 0;                    ///< threads that wait for the lock

    bool stops_this_thread() const { return last && *last != std::this_thread::get_id(); }
};

namespace {

/// Never freed: threads may use it until the process is gone.
Threads* all_threads = new Threads;

/// A forked process has none of the other threads, and its lock may be held by one of them.
void forget_other_threads() { all_threads = new Threads; }

/// Must come before a thread asks for the lock, and `after_asking` afterwards.
void before_asking(Threads& t) {
    // Under one lock, the thread is either counted as asking, and the end waits for it, or it sees that all
    // is closed.
    {
        const std::lock_guard lock(t.mutex);
        if (!t.closed || !t.stops_this_thread()) {
            ++t.asking;
            return;
        }
    }
    // Outside the braces: the mutex is free while this thread sleeps.
    sleep_for_ever();
}

void after_asking(Threads& t, bool back) {
    const std::lock_guard lock(t.mutex);
    --t.asking;
    if (back) --t.outside;
    t.fewer.notify_all();
}

/// Waits without the lock until `done` or `patience` is over; Ctrl-C ends the waiting.
template <class Done>
void wait_without_lock(Threads& t, std::chrono::milliseconds patience, Done done) {
    const auto end = std::chrono::steady_clock::now() + patience;
    for (bool over = false; !over;) {
        // The lock of Python must be free here, or the others could never get it and leave.
        {
            const py::gil_scoped_release release;  // of the thread that ends the interpreter
            std::unique_lock lock(t.mutex);
            over = t.fewer.wait_for(lock, kTick, done) || std::chrono::steady_clock::now() > end;
        }
        // A user who presses Ctrl-C wants the process to end now.
        if (PyErr_CheckSignals() != 0) {
            PyErr_Clear();
            over = true;
        }
    }
}

/// Three steps, in this order:
/// 1. Calls see that the interpreter ends (`must_stop`) and are cancelled; the end waits until they are back.
/// 2. What has not come back by then may not ask for the lock any more.
/// 3. Those that have asked before get it, and then nobody is left who could ask too late.
void stop_calls() {
    Threads& t = *all_threads;
    {
        const std::lock_guard lock(t.mutex);
        t.last = std::this_thread::get_id();
    }
    wait_without_lock(t, kPatience, [&] { return t.outside == 0; });
    {
        const std::lock_guard lock(t.mutex);
        t.closed = true;
    }
    // Those who ask already get the lock, as this thread does not hold it
    wait_without_lock(t, kPatience, [&] { return t.asking == 0; });
}

}  // namespace

void sleep_for_ever() {
    for (;;) pause();
}

bool must_stop() {
    const std::lock_guard lock(all_threads->mutex);
    return all_threads->stops_this_thread();
}

void leave_thread() {
    PyErr_SetNone(PyExc_SystemExit);
    throw py::error_already_set();
}

WithoutGil::WithoutGil() : threads_(all_threads) {
    // Before the lock is released: a thread that need not leave Python can raise at once.
    if (must_stop()) leave_thread();
    {
        const std::lock_guard lock(threads_->mutex);
        ++threads_->outside;
    }
    state_ = PyEval_SaveThread();
}

WithoutGil::~WithoutGil() {
    // The counterpart of the constructor: ask, get the lock back, and be counted as inside again.
    before_asking(*threads_);
    PyEval_RestoreThread(state_);
    after_asking(*threads_, true);
}

WithGil::WithGil() {
    Threads& t = *all_threads;
    // A thread that already has the lock need not wait for it.
    const bool held = PyGILState_Check() != 0;
    if (!held) before_asking(t);
    state_ = PyGILState_Ensure();
    if (!held) after_asking(t, false);
}

void stop_calls_at_exit() {
    // A child process starts with fresh counts: the mutex it inherited may be locked for ever.
    pthread_atfork(nullptr, nullptr, forget_other_threads);
    py::module_::import("atexit").attr("register")(py::cpp_function(stop_calls));
}

}  // namespace viscache::bindings

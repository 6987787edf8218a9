#pragma once
// The interpreter's lock (GIL) around long calls, and what becomes of these calls when the interpreter ends.
//
// A daemon thread that asks for the lock of an interpreter that ends is killed by CPython (before 3.14), and
// the killing unwinds through C++ that must not throw: the process aborts. So nothing here may ask too late:
// 1. `stop_calls_at_exit` runs while Python still works. It cancels the calls of other threads and waits.
// 2. Calls that end raise SystemExit in their thread, which `threading` ends without a word.
// 3. Calls that do not end in time never ask again: their threads sleep until the process is gone.
#include <pybind11/pybind11.h>

#include <cxxabi.h>

#include "viscache/math/float_mode.h"

namespace viscache::bindings {

/// Releases the lock while it lives, and computes in the default floating-point mode. Throws SystemExit when
/// the interpreter ends and this is not its thread.
class WithoutGil {
public:
    WithoutGil();
    ~WithoutGil();
    WithoutGil(const WithoutGil&) = delete;
    WithoutGil& operator=(const WithoutGil&) = delete;

private:
    DefaultFloats floats_;
    struct Threads* threads_;
    PyThreadState* state_;
};

/// Holds the lock while it lives, in any thread.
class WithGil {
public:
    WithGil();
    ~WithGil() { PyGILState_Release(state_); }
    WithGil(const WithGil&) = delete;
    WithGil& operator=(const WithGil&) = delete;

private:
    PyGILState_STATE state_;
};

/// Sleeps until the process is gone.
[[noreturn]] void sleep_for_ever();

/// Calls `call` with the lock. `call` may run Python code, and in there CPython may kill this thread.
template <class Call>
decltype(auto) with_python(Call call) {
    const WithGil lock;
    try {
        return call();
    } catch (abi::__forced_unwind&) {
        sleep_for_ever();
    }
}

/// Whether the interpreter ends and this thread is not the one that ends it.
bool must_stop();

/// Raises SystemExit.
[[noreturn]] void leave_thread();

/// Registers the hook that ends the calls of other threads before the interpreter ends.
void stop_calls_at_exit();

}  // namespace viscache::bindings

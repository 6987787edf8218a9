#pragma once
// A small test harness without dependencies, for the sanitizer builds. A test file defines
// `const Suite suite{...}` at namespace scope; main runs every suite that was linked in.
#include <functional>
#include <sstream>
#include <string>
#include <vector>

namespace viscache::test {

struct Test {
    std::string name;  ///< a sentence that states the claim
    std::function<void()> body;
};

/// All tests linked into the executable.
std::vector<Test>& registry();
/// Records a failure of the running test; the test continues.
void fail(const std::string& what);

struct Suite {
    Suite(std::initializer_list<Test> tests) { registry().insert(registry().end(), tests); }
};

inline void check(bool holds, const std::string& claim) {
    if (!holds) fail(claim);
}

template <class A, class B>
void check_equal(const A& got, const B& expected, const std::string& what) {
    if (got == expected) return;
    std::ostringstream message;
    message << what << ": expected " << expected << ", got " << got;
    fail(message.str());
}

/// |got − expected| <= tolerance; a NaN fails.
inline void check_near(double got, double expected, double tolerance, const std::string& what) {
    const double error = got > expected ? got - expected : expected - got;
    if (error <= tolerance) return;
    std::ostringstream message;
    message.precision(17);
    message << what << ": expected " << expected << " ± " << tolerance << ", got " << got;
    fail(message.str());
}

/// `body` must throw an Error.
template <class Error, class Body>
void check_throws(Body body, const std::string& what) {
    try {
        body();
    } catch (const Error&) {
        return;
    }
    fail(what + ": nothing was thrown");
}

}  // namespace viscache::test

// Runs all tests, or those whose name contains the first argument. Prints failures and totals.
#include <cstdio>
#include <exception>

#include "check.h"

namespace viscache::test {

std::vector<Test>& registry() {
    static std::vector<Test> tests;
    return tests;
}

namespace {
int failures_of_test = 0;
}

void fail(const std::string& what) {
    // Print at most twenty failures per test.
    if (++failures_of_test <= 20) std::printf("    %s\n", what.c_str());
}

/// Returns true if the test passed.
bool run(const Test& test) {
    failures_of_test = 0;
    try {
        test.body();
    } catch (const std::exception& e) {
        fail(std::string("threw ") + e.what());
    } catch (...) {
        fail("threw something other than a std::exception");
    }
    if (failures_of_test) std::printf("FAILED %s (%d checks)\n", test.name.c_str(), failures_of_test);
    return failures_of_test == 0;
}

}  // namespace viscache::test

int main(int argc, char** argv) {
    using namespace viscache::test;
    const std::string filter = argc > 1 ? argv[1] : "";
    int passed = 0, failed = 0;
    for (const Test& test : registry())
        if (test.name.find(filter) != std::string::npos) ++(run(test) ? passed : failed);
    std::printf("%d passed, %d failed\n", passed, failed);
    return failed || !passed ? 1 : 0;
}

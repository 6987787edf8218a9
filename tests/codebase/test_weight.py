"""The weight of the repository has limits, which each step lowers."""

from codebase.weight import cpp_lines, long_in_cpp, weigh

#: At most so much. What must not shrink is in LEAST.
LIMITS = {
    "library, lines": 79_400,
    "python, lines": 31_000,
    "lab, lines": 16_900,
    "tests, lines": 52_700,
    "rooms": 19,
    "imports between rooms": 90,
    "imports that run back up": 5,
    "circles": 0,
    "units": 18,
    "parameters of entry points": 50,
    "settings fields": 135,
    "virtuals of VisibilityOracle": 6,
    "overrides of them": 48,
    "long functions": 0,
    "README, words": 920,
    "performance, words": 38_100,
    "reference, words": 19_250,
    "user pages, words": 33_100,
}
LEAST = {"C++ comments, lines per 1000": 122}


def test_nothing_grows_and_limits_are_near_what_is_there():
    """Near, so that a step that takes away lowers them."""
    found = weigh()
    over = {name: found[name] for name, limit in LIMITS.items() if found[name] > limit}
    under = {name: found[name] for name, limit in LEAST.items() if found[name] < limit}
    assert over == {}, LIMITS
    assert under == {}, LEAST
    far = {n: found[n] for n, limit in LIMITS.items() if found[n] < 0.97 * limit - 1}
    assert far == {}, LIMITS


def test_lines_of_comments_and_long_functions_are_found():
    assert cpp_lines("// a\n/* b\n c */\nint d;  // e\n") == (4, 3)
    body = "".join(f"    f({i});\n" for i in range(90))
    source = f"namespace v {{\nvoid g(int a) {{\n{body}}}\n\nvoid h() {{\n    f();\n}}\n}}\n"
    (found,) = long_in_cpp("a.cpp", source)
    assert found.startswith("a.cpp: void g(int a) {, 92 lines")

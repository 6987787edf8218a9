"""The weight of the repository has limits, which each step lowers."""

from __future__ import annotations

from codebase.weight import cpp_lines, long_in_cpp, weigh

#: At most so much. What must not shrink is in LEAST.
LIMITS = {}
LEAST = {}


def test_nothing_grows() -> None:
    found = weigh()
    over = {name: found[name] for name, limit in LIMITS.items() if found[name] > limit}
    under = {name: found[name] for name, limit in LEAST.items() if found[name] < limit}
    assert over == {}, LIMITS
    assert under == {}, LEAST


def test_limits_are_near_what_is_there() -> None:
    """So that a step that takes away lowers them."""
    found = weigh()
    far = {n: found[n] for n, limit in LIMITS.items() if found[n] < 0.97 * limit - 1}
    assert far == {}, LIMITS


def test_lines_of_comments_and_long_functions_are_found() -> None:
    assert cpp_lines("// a\n/* b\n c */\nint d;  // e\n") == (4, 3)
    body = "".join(f"    f({i});\n" for i in range(90))
    source = f"namespace v {{\nvoid g(int a) {{\n{body}}}\n\nvoid h() {{\n    f();\n}}\n}}\n"
    (found,) = long_in_cpp("a.cpp", source)
    assert found.startswith("a.cpp: void g(int a) {, 92 lines")

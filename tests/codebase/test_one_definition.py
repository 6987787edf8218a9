"""Two inline functions of one name and signature must be one function: the linker keeps either."""

import re

from codebase.repository import sources

#: `inline` or `constexpr` functions at the start of a line: name, with the class of a member, and
#: parameters, up to the body.
FUNCTION = re.compile(
    r"^(?:\[\[\w+\]\] )?(?:inline|constexpr)\b[^\n;={}()]*?"
    r"\b((?:\w+::)*\w+)\(([^;{}]*?)\)[^;{}()]*\{",
    re.M,
)
NAMESPACE = re.compile(r"^namespace ([\w:]+) \{|^\}  // namespace ([\w:]+)", re.M)


def enclosing(source, position):
    """Namespaces open at a position; their ends are marked in every file."""
    names = []
    for match in NAMESPACE.finditer(source, 0, position):
        if match[1]:
            names.append(match[1])
        elif match[2] in names:
            names.remove(match[2])
    return "::".join(names)


def signature(parameters):
    """Types of the parameters: their names and defaults say nothing to the linker."""
    types = []
    for parameter in re.sub(r"<[^<>]*>", "<>", parameters).split(","):
        bare = re.sub(r"\s*=.*", "", parameter.strip())
        types.append(re.sub(r"(?<=[\w&*>])\s+\w+$|(?<=[&*])\w+$", "", bare))
    return ", ".join(types)


def repeated(files):
    found = {}
    for path, source in files.items():
        for match in FUNCTION.finditer(source):
            name = f"{enclosing(source, match.start())}::{match[1]}({signature(match[2])})"
            found.setdefault(name, []).append(path)
    return {name: places for name, places in found.items() if len(places) > 1}


def test_no_two_headers_define_the_same_function():
    files = sources(".h", under="cpp/") | sources(".h", under="tests/core/")
    assert sum(len(FUNCTION.findall(source)) for source in files.values()) > 100
    assert repeated(files) == {}


def test_a_second_definition_is_found():
    body = (
        "namespace viscache {{\ninline int f(int {0}) {{\n    return {1};\n}}\n"
        "}}  // namespace viscache\n"
    )
    files = {"a.h": body.format("a", "a"), "b.h": body.format("b", "b + 1")}
    assert list(repeated(files)) == ["viscache::f(int)"]
    other = body.format("a", "2").replace("int a", "double a")
    assert repeated({"a.h": files["a.h"], "b.h": other}) == {}
    members = {name: text.replace(" f(", f" {name[0].upper()}::f(") for name, text in files.items()}
    assert repeated(members) == {}
    assert list(repeated({"a.h": members["a.h"], "c.h": members["a.h"]})) == ["viscache::A::f(int)"]

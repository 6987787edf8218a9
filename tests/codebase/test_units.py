"""The units that compilers read (cpp/units.txt), and what their files must keep so that they can be
one."""

import re
from collections import defaultdict
from collections.abc import Callable, Iterator
from fnmatch import fnmatch
from pathlib import PurePosixPath

import pytest

from codebase.repository import paths, text

NOT_CODE = re.compile(
    r"""//[^\n]*|/\*.*?\*/|"(?:\\.|[^"\\\n])*"|'(?:\\.|[^'\\])'|^ *#(?:\\\n|[^\n])*""",
    re.S | re.M,
)
TYPE = re.compile(r"(?:struct|class|union|enum(?: class)?) (\w+)(?: final)?(?: ?:[^:].*)?\{\}")
ALIAS = re.compile(r"using (\w+) =")
ATTRIBUTE = r"__attribute__ ?\((?:[^()]|\((?:[^()]|\([^()]*\))*\))*\)"
SKIPPED = re.compile(ATTRIBUTE + r"|\[\[.*?\]\]|template ?<.*?> (?=\w)")
COMPILED = (*paths(".cpp", under="cpp/"), *paths(".cpp", under="tests/core/"))
NAME_BEFORE_VALUE = re.compile(r"(\w+)(?:\[[^\]]*\])* ?$")


def units() -> dict[str, tuple[float, float, list[str]]]:
    """Seconds, megabytes and files of each unit, in the order of the table."""
    rows = [line.split() for line in text("cpp/units.txt").splitlines() if line[:1].isalpha()]
    return {
        row[0]: (
            float(row[1]),
            float(row[2]),
            [path for path in COMPILED if any(fnmatch(path, pattern) for pattern in row[4:])],
        )
        for row in rows
    }


def private_names(source: str) -> Iterator[str]:
    """Names that a file defines in its anonymous namespaces."""
    plain = NOT_CODE.sub(" ", source)
    for begin in re.finditer(r"\bnamespace\s*\{", plain):
        depth, outside = 1, ""  # what stands outside of all braces but those of the namespace
        for c in plain[begin.end() :]:
            depth += (c == "{") - (c == "}")
            if depth == 0:
                break
            if depth == 1:
                outside += "{};" if c == "}" else c
        for statement in SKIPPED.sub("", " ".join(outside.split())).split(";"):
            statement = statement.strip()
            if found := TYPE.match(statement) or ALIAS.match(statement):
                yield found[1]
            elif re.match(r"(?!using )[\w,]", statement):  # not what follows braces
                head = re.split(r"=|\{\}", statement)[0]
                called = re.search(r"(\w+|operator\S+) ?\(", head)
                yield called[1] if called else NAME_BEFORE_VALUE.findall(head)[0]


def clashes(files: dict[str, str], home_of: Callable[[str], str]) -> dict[str, list[str]]:
    """Private names that several files of a home define, with these files."""
    homes = defaultdict(list)
    for path, source in files.items():
        for name in set(private_names(source)):
            homes[home_of(path), name].append(path)
    return {name: where for (_, name), where in homes.items() if len(where) > 1}


def folder_of(path: str) -> str:
    return str(PurePosixPath(path).parent)


def test_every_file_is_in_one_unit() -> None:
    of_units = [path for _, _, files in units().values() for path in files]
    assert sorted(of_units) == sorted(COMPILED)


def test_the_longest_units_come_first_and_none_is_too_large() -> None:
    seconds = [row[0] for row in units().values()]
    assert seconds == sorted(seconds, reverse=True), "run scripts/weigh_units"
    assert len(seconds) <= 32
    assert max(megabytes for _, megabytes, _ in units().values()) <= 1050


def test_files_of_a_unit_or_a_folder_have_private_names_of_their_own() -> None:
    """Two files of a unit must not define one name; any files of a folder may share a unit."""
    files = {path: text(path) for path in COMPILED}
    unit_of = {path: unit for unit, (_, _, paths) in units().items() for path in paths}
    assert sum(len(list(private_names(source))) for source in files.values()) > 500
    assert clashes(files, folder_of) == {}
    assert clashes(files, unit_of.__getitem__) == {}


@pytest.mark.parametrize(
    ("source", "names"),
    [
        ("namespace { int f(int x) { return g(x); } }", ["f"]),
        ("namespace { constexpr float kA = h(2), kB = 3; }", ["kA"]),
        ("namespace { struct A final : B { int x; }; class C { }; }", ["A", "C"]),
        ("namespace { using V = std::vector<int>; using std::max; }", ["V"]),
        ("namespace { template <class T> [[noreturn]] void fail(const T& t) { } }", ["fail"]),
        ("namespace { const std::array<int, 2> kTable{1, 2}; int last[3]; }", ["kTable", "last"]),
        ("namespace {\n#define X 1\n// int no();\nenum class E { kA }; }", ["E"]),
        ("namespace a { int f(); }", []),
    ],
)
def test_private_names_are_found(source: str, names: list[str]) -> None:
    assert list(private_names(source)) == names


def test_a_clash_is_found() -> None:
    one, other = "namespace { int f() { } }", "namespace { void f(int) { } }"
    assert clashes({"cpp/a/x.cpp": one, "cpp/a/y.cpp": other}, folder_of) == {
        "f": ["cpp/a/x.cpp", "cpp/a/y.cpp"]
    }
    assert clashes({"cpp/a/x.cpp": one, "cpp/b/y.cpp": other}, folder_of) == {}

"""House rules that a test can check."""

import json
import re
from pathlib import PurePosixPath

import pytest

import viscache
from codebase.repository import ROOT, paths, sources, text

CODE = (".py", ".h", ".cpp", ".txt", ".toml")
SCRIPTS = ("scripts/", ".ci/")
MAX_LINES = 500
# Written in pieces, so that this file does not contain what it forbids.
FORBIDDEN = {
    "a path of one machine": r"(?<![\w./-])/(?:wo"
    + r"rk|ro"
    + r"ot|fa"
    + r"rm|ho"
    + r"me|tmp/\w+)\b",
    "a host of a package registry": r"\b(?:py" + r"pi\.org|pythonho" + r"sted|deb\.deb" + r"ian)",
    "unsafe floating point": r"-ff" + r"ast-math|-Of" + r"ast\b|-funsafe-m" + r"ath",
    "work left for later": r"\b(?:TO" + r"DO|FIX" + r"ME|XX" + r"X|HA" + r"CK)\b",
}

HYPOT = r"\bhypotf?\("


def code():
    scripts = {path: text(path) for path in paths() if path.startswith(SCRIPTS)}
    return sources(*CODE) | scripts


def offences(files, pattern):
    return [
        f"{path}:{number}: {line.strip()}"
        for path, source in files.items()
        for number, line in enumerate(source.splitlines(), 1)
        if re.search(pattern, line)
    ]


def test_files_have_at_most_500_lines():
    files = {path: source for path, source in code().items() if "_core/" not in path}
    assert [path for path, source in files.items() if source.count("\n") > MAX_LINES] == []


@pytest.mark.parametrize("what", FORBIDDEN)
def test_nothing_forbidden_is_committed(what):
    files = code() | sources(".md", ".cff", ".yaml", ".yml", ".json", ".ipynb", ".pyi")
    assert len(files) > 10
    assert offences(files, FORBIDDEN[what]) == []


@pytest.mark.parametrize(
    ("what", "line"),
    [
        ("a path of one machine", "data = '/ro" + "ot/data'"),
        ("a path of one machine", "cd /tmp" + "/scene"),
        ("a host of a package registry", "https://py" + "pi.org/simple"),
        ("unsafe floating point", "add_compile_options(-ffa" + "st-math)"),
        ("work left for later", "// TO" + "DO: later"),
    ],
)
def test_a_forbidden_line_is_found(what, line):
    assert offences({"made_up": line}, FORBIDDEN[what])


def test_the_lock_of_the_interpreter_has_one_home():
    # A call that asks for it by other means aborts the process if the interpreter ends meanwhile.
    others = {path: source for path, source in sources(".h", ".cpp").items() if "/gil." not in path}
    assert any("WithoutGil" in source for source in others.values())
    assert offences(others, r"gil_scoped_|PyGILState_|PyEval_(?:Save|Restore)Thread") == []


def test_nothing_binds_wheels_to_glibc_2_35():
    # Debian 12's Embree needs 2.34, as RHEL 9 has it. This function alone would ask for more.
    files = sources(".h", ".cpp", under="cpp")
    assert len(files) > 100
    assert offences(files, HYPOT) == []
    assert offences({"made_up": "return std::hypot(x, y);"}, HYPOT) != []


def test_every_folder_of_the_core_has_tests():
    folders = {PurePosixPath(path).parts[2] for path in paths(".h", ".cpp", under="cpp/viscache/")}
    python = {path.split("/")[1] for path in paths(".py", under="tests/") if "/test_" in path}
    native = "".join(sources(".cpp", under="tests/cpp/").values())
    assert folders - python - set(re.findall(r'#include "viscache/(\w+)/', native)) == set()


#: Folders of tests that are no room of the code: what they hold is of all rooms.
NO_ROOMS = {"browser", "codebase", "core", "cpp", "distributed", "docs", "fuzz", "golden", "lab"}
NO_ROOMS |= {"memory", "mutants", "notebooks", "reference", "unbiased"}


def test_tests_lie_in_folders_named_as_the_rooms():
    rooms = {PurePosixPath(path).parts[2] for path in paths(".h", ".cpp", under="cpp/viscache/")}
    rooms |= {PurePosixPath(p).parts[2] for p in paths(".py", under="python/viscache/")}
    found = {path.split("/")[1] for path in paths(".py", under="tests/")} - {"conftest.py"}
    assert found - {room.removesuffix(".py") for room in rooms} == NO_ROOMS - {"cpp"}


def test_the_version_is_the_same_everywhere():
    def find(path, pattern):
        match = re.search(pattern, text(path), re.M)
        assert match, f"{path} must hold {pattern}"
        return match[1]

    version = find("pyproject.toml", r'^version = "(.+)"$')
    assert find("python/viscache.dist-info/METADATA", r"^Version: (.+)$") == version
    assert find("CITATION.cff", r'^version: "?([^"\n]+)') == version
    assert find("CHANGELOG.md", r"^## (\d\S*)") == version
    assert viscache.__version__ == version


def test_notebooks_hold_no_outputs():
    kept = [
        path
        for path, source in sources(".ipynb").items()
        for cell in json.loads(source)["cells"]
        if cell.get("outputs") or cell.get("execution_count") is not None
    ]
    assert kept == []


def broken_links(path, source):
    """Targets of relative links and pictures that are not there."""
    folder = (ROOT / path).parent
    targets = re.findall(r"\]\(([^)\s]+)[^)]*\)|(?:src|href)=\"([^\"]+)\"", source)
    local = [a or b for a, b in targets if not re.match(r"[a-z]+:|#", a or b)]
    return [f"{path}: {t}" for t in local if not (folder / t.partition("#")[0]).exists()]


def test_links_between_documents_resolve():
    files = sources(".md")
    assert "README.md" in files
    assert [link for path, source in files.items() for link in broken_links(path, source)] == []


def test_a_broken_link_is_found():
    assert broken_links("docs/a.md", "see [this](../README.md) and [that](missing.md#part)") == [
        "docs/a.md: missing.md#part"
    ]

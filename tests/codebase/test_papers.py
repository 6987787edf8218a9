"""docs/papers.md is true: the table and the tagged homes in the C++ agree both ways."""

import pkgutil
import re
from dataclasses import dataclass, replace

import pytest

from codebase.repository import paths, sources, text
from lab.figures.test_quick_runs import QUICK
from viscache_lab.figures import FIGURES

STATES = ("here", "later", "text")
# All numbered items of the papers. The VLF paper does not number equations.
NUMBERED = {
    "AQVC": {"Eq.": 12, "Alg.": 2, "Fig.": 8},
    "VLF": {"Fig.": 8, "Table": 1},
    "VisMap": {"Eq.": 12, "Fig.": 14, "Table": 3},
}
# Constructions that have no number, by their section.
SECTIONS = {
    "AQVC": ("3.3", "3.5", "4.1", "4.2", "4.3", "4.4"),
    "VLF": ("3.1", "3.2", "3.3", "4", "5.1", "7", "8"),
    "VisMap": ("4.1", "5.1", "5.2", "5.3", "6.1", "6.2"),
}
QUICK_RUNS = "tests/lab/figures/test_quick_runs.py"
TAG = re.compile(r"\[((?:AQVC|VLF|VisMap) (?:Eq\.|Alg\.) \d+)\]")
NOTHING = "–"


@dataclass(frozen=True, kw_only=True, slots=True)
class Row:
    item: str
    what: str
    home: str
    python: str
    test: str
    state: str


def rows(table):
    """Rows of the tables of docs/papers.md; an item is written as its tag, `AQVC Eq. 8`."""
    found = []
    for line in table.splitlines():
        cells = [cell.strip() for cell in line.strip().strip("|").split("|")]
        if line.startswith("|") and re.match(r"(AQVC|VLF|VisMap) ", cells[0]):
            item, what, *rest, state = cells
            home, python, test = (re.sub(r"`", "", cell) for cell in rest)
            row = Row(
                item=item, what=what, home=home, python=python, test=test, state=state.strip("*")
            )
            found.append(row)
    return found


def homes(files):
    """The place of each tag, `path:line`."""
    found = {}
    for path, source in files.items():
        for number, line in enumerate(source.splitlines(), 1):
            for tag in TAG.findall(line):
                found.setdefault(tag, []).append(f"{path}:{number}")
    return found


def disagreements(table, files):
    tagged = homes(files)
    items = {row.item: row for row in table}
    for tag, places in tagged.items():
        if tag not in items:
            yield f"{tag} is tagged in {', '.join(places)} and has no row in docs/papers.md"
        elif items[tag].state != "here":
            state = items[tag].state
            yield f"{tag} is tagged in {', '.join(places)}: set it to here, not {state}"
        if len(places) > 1:
            yield f"{tag} must have one home, has {', '.join(places)}"
    for row in table:
        if row.state not in STATES:
            yield f"{row.item}: state must be one of {', '.join(STATES)}, got {row.state!r}"
        if row.state != "here":
            continue
        places = tagged.get(row.item, [])
        if TAG.match(f"[{row.item}]") and not any(p.rpartition(":")[0] == row.home for p in places):
            found = ", ".join(places) or "no file"
            yield f"{row.item}: {row.home} must hold the tag [{row.item}], found it in {found}"


def test_every_numbered_item_of_the_papers_has_one_row():
    listed = [row.item for row in rows(text("docs/papers.md"))]
    expected = {
        f"{paper} {kind} {number}"
        for paper, kinds in NUMBERED.items()
        for kind, count in kinds.items()
        for number in range(1, count + 1)
    }
    expected |= {f"{paper} Sec. {number}" for paper, all_ in SECTIONS.items() for number in all_}
    assert sorted(listed) == sorted(expected)
    assert len(listed) == len(set(listed))


def test_table_and_tags_agree_both_ways():
    table = rows(text("docs/papers.md"))
    assert list(disagreements(table, sources(".h", ".cpp", under="cpp/"))) == []


def test_tags_open_the_doc_comment_of_their_home():
    stray = [
        f"{path}: {line.strip()}"
        for path, source in sources(".h", ".cpp", under="cpp/").items()
        for line in source.splitlines()
        if TAG.search(line) and not re.match(r"\s*/// \[", line)
    ]
    assert stray == []


def built_rows():
    return [row for row in rows(text("docs/papers.md")) if row.state == "here"]


def test_what_is_built_names_an_existing_file():
    known = {NOTHING, *paths(".h", ".cpp", under="cpp/")}
    assert [f"{row.item}: {row.home}" for row in built_rows() if row.home not in known] == []


def test_what_is_built_names_an_existing_test():
    known = set(paths(".py", ".cpp", under="tests/"))
    missing = []
    for row in built_rows():
        path, _, name = row.test.partition("::")
        if path not in known or not (name in text(path) or name in QUICK):
            missing.append(f"{row.item}: the test must exist, got {row.test}")
    assert missing == []


def test_what_is_built_names_an_existing_python_object():
    missing = []
    for row in built_rows():
        if row.python == NOTHING:
            continue
        try:
            pkgutil.resolve_name(row.python)
        except (ImportError, AttributeError):
            missing.append(f"{row.item}: there is no {row.python}")
    assert missing == []


def figures_without_their_run(table, functions):
    """Rows whose test is not the quick run of their figure; `functions`: Python name to figure."""
    for row in table:
        if row.python.startswith("viscache_lab.figures."):
            name = functions.get(row.python)
            if name is None or row.test != f"{QUICK_RUNS}::{name}":
                yield f"{row.item}: the test must be the quick run of {name}, got {row.test}"


def test_every_figure_names_the_test_that_runs_it():
    functions = {
        f"{info.function.__module__}.{info.function.__qualname__}": name
        for name, info in FIGURES.items()
    }
    table = built_rows()
    assert list(figures_without_their_run(table, functions)) == []
    run = {row.test.partition("::")[2] for row in table if row.test.startswith(QUICK_RUNS)}
    numbered = {name for name in FIGURES if re.fullmatch(r"\w+-(fig|tab)\d+", name)}
    assert run == numbered and numbered <= set(QUICK)


@pytest.mark.parametrize("test", [f"{QUICK_RUNS}::aqvc-fig3", QUICK_RUNS, "tests/a.py::aqvc-fig2"])
def test_a_figure_with_another_test_is_reported(test):
    row = replace(LATER, python="viscache_lab.figures.a.f", test=f"{QUICK_RUNS}::aqvc-fig2")
    functions = {"viscache_lab.figures.a.f": "aqvc-fig2"}
    assert list(figures_without_their_run([row], functions)) == []
    assert len(list(figures_without_their_run([replace(row, test=test)], functions))) == 1
    assert len(list(figures_without_their_run([row], {}))) == 1


LATER = Row(item="AQVC Eq. 8", what="", home="", python=NOTHING, test="", state="later")
MADE_UP = replace(LATER, home="cpp/viscache/aqvc/a.h", state="here")
HOME = {"cpp/viscache/aqvc/a.h": "/// [AQVC Eq. 8] The ladder.\n"}


def test_a_true_table_is_not_reported():
    assert list(disagreements([MADE_UP], HOME)) == []
    assert list(disagreements([LATER], {})) == []


@pytest.mark.parametrize(
    ("table", "files", "expected"),
    [
        ([MADE_UP], {}, "must hold the tag"),
        ([MADE_UP], {"cpp/viscache/aqvc/b.h": "/// [AQVC Eq. 8] Moved.\n"}, "must hold the tag"),
        ([MADE_UP], {**HOME, "cpp/viscache/aqvc/b.h": "/// [AQVC Eq. 8] Again.\n"}, "one home"),
        ([LATER], HOME, "set it to here"),
        ([], HOME, "no row in docs/papers.md"),
    ],
)
def test_a_false_table_is_reported(table, files, expected):
    found = list(disagreements(table, files))
    assert len(found) == 1
    assert expected in found[0]

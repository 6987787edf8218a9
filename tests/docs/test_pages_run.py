"""The code of the documentation runs and prints the output shown below it."""

import ast
import io
import os
import re
import shlex
import subprocess
import sys
import warnings
from contextlib import redirect_stdout
from dataclasses import dataclass
from pathlib import Path

import pytest

import viscache
from codebase.repository import paths, text
from viscache import cli
from viscache.sweeps.sweep import SweepFile

#: Tolerance of printed numbers: rays and errors depend on the instruction set by far less.
TOLERANCE = 0.05
#: Pages that print what a search ends at, or statistics of noise; either may jump.
LOOSER = {"docs/howto/own-cache.md": 0.25, "docs/howto/pytest.md": 0.25}
#: Pages that take more than a second or two.
SLOW = {
    "README.md",
    *(
        f"docs/{page}.md"
        for page in ("aqvc", "cluster", "correlation", "tutorial", "vismap", "vlf")
    ),
    *(
        f"docs/howto/{page}.md"
        for page in (
            *(
                "ambient-occlusion",
                "cluster",
                "correlation",
                "own-cache",
                "own-integrator",
                "passes",
            ),
            *("pytest", "report", "sweep", "unbiased"),
        )
    ),
}
PAGES = [p for p in paths(".md") if p.startswith(("docs/", "README", "notebooks/"))]
BLOCK = re.compile(r"^```(\w+)\n(.*?)^```$", re.S | re.M)
NUMBER = re.compile(r"-?\d+(?:\.\d+)?(?:e-?\d+)?")


@dataclass(frozen=True)
class Block:
    kind: str
    text: str
    line: int


def blocks(source):
    for match in BLOCK.finditer(source):
        yield Block(match[1], match[2], source[: match.start()].count("\n") + 2)


def alike(said, printed, tolerance=TOLERANCE):
    """Equal text; numbers with a decimal point, or from 10 on, may differ a little."""
    if re.sub(r"\s", "", NUMBER.sub("#", said)) != re.sub(r"\s", "", NUMBER.sub("#", printed)):
        return False
    pairs = zip(NUMBER.findall(said), NUMBER.findall(printed), strict=True)
    return all(
        a == b
        or (
            (float(a) >= 10 or "." in a)
            and abs(float(a) - float(b)) <= tolerance * max(abs(float(a)), abs(float(b)))
        )
        for a, b in pairs
    )


def run(source, name):
    """Run a page's Python in one namespace and compare its outputs; return the number of blocks."""
    space = {"__name__": "page"}
    printed, ran = "", 0
    for block in blocks(source):
        if block.kind == "python":
            out = io.StringIO()
            tree = ast.parse(block.text, name)
            ast.increment_lineno(tree, block.line - 1)
            with redirect_stdout(out):
                exec(compile(tree, name, "exec", dont_inherit=True), space)
            printed, ran = out.getvalue(), ran + 1
        elif block.kind == "text":
            assert alike(block.text, printed, LOOSER.get(name, TOLERANCE)), (
                f"{name}:{block.line} says\n{block.text}\ngot\n{printed}"
            )
        elif block.kind == "toml" and sys.version_info >= (3, 11):
            import tomllib

            SweepFile.from_table(tomllib.loads(block.text))
    return ran


WITH_CODE = [p for p in PAGES if any(b.kind == "python" for b in blocks(text(p)))]


@pytest.mark.parametrize(
    "page", [pytest.param(p, marks=pytest.mark.slow if p in SLOW else ()) for p in WITH_CODE]
)
def test_the_code_of_a_page_runs_and_prints_what_it_says(page, tmp_path, monkeypatch):
    if "import dask" in text(page):
        pytest.importorskip("distributed", reason="dask comes with the test extra")
        warnings.simplefilter("default")  # dask's own are not ours; pytest restores the filters
    monkeypatch.chdir(tmp_path)
    run(text(page), page)


def test_the_tests_on_a_page_pass(tmp_path):
    """Those that a reader copies into a file of his own."""
    page = "docs/howto/pytest.md"
    code = [b.text for b in blocks(text(page)) if b.kind == "python" and "print(" not in b.text]
    (tmp_path / "test_page.py").write_text("\n".join(code), encoding="utf-8")
    (tmp_path / "pytest.ini").touch()
    command = [sys.executable, "-m", "pytest", "-q", "-p", "pytest_viscache", str(tmp_path)]
    path = os.pathsep.join([str(Path(viscache.__file__).parents[1]), *sys.path])
    done = subprocess.run(
        command,
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": path, "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1"},
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stdout
    assert "4 passed" in done.stdout


def test_pages_for_users_have_code():
    assert set(WITH_CODE) >= {*SLOW, "docs/which-cache.md"}
    howtos = [p for p in PAGES if p.startswith("docs/howto/")]
    commanded = {p for p in howtos if any(commands(text(p)))}
    assert len((set(howtos) & set(WITH_CODE)) | commanded) >= len(howtos) - 1  # all but their index


def test_a_page_that_says_something_else_is_found():
    page = "```python\nprint('a', 10.0, 3)\n```\n```text\n{}\n```\n"
    assert run(page.format("a 10.4 3"), "page") == 1
    assert run(page.format("a 12.0 3"), next(iter(LOOSER))) == 1
    for wrong in ("b 10.0 3", "a 10.6 3", "a 10.0 4", "a 10.0"):
        with pytest.raises(AssertionError, match="page:5 says"):
            run(page.format(wrong), "page")


def commands(source):
    """Command lines of viscache in shell blocks; a comment ends one."""
    for block in blocks(source):
        for line in re.sub(r"\\\n", " ", block.text).splitlines() if block.kind == "sh" else ():
            words = shlex.split(line, comments=True)
            if words[:1] == ["viscache"]:
                yield words[1:]


@pytest.mark.parametrize("page", [p for p in PAGES if any(commands(text(p)))])
def test_command_lines_on_pages_are_understood(page):
    for words in commands(text(page)):
        cli._parser(words).parse_args(words)


def test_a_wrong_command_line_is_found(capsys):
    (words,) = commands("```sh\nviscache render room \\\n  --sise 4x4 -o a.exr  # small\n```\n")
    with pytest.raises((SystemExit, ValueError)):
        cli._parser(words).parse_args(words)

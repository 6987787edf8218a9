"""The package uses all that `viscache._core` binds; what only tests use is bound in tests/core."""

import ast
import os
import re
import shutil
import subprocess
import sys
import types

import pytest

from codebase.repository import ROOT, paths, sources, text
from core import testing
from viscache import _core

CORE = "viscache._core"
TESTING = "core.testing"
MODULES = (CORE, TESTING)
STUBS = "python/viscache/_core/"


def bound(module, prefix):
    """Dotted names that a C++ module binds."""
    for name, value in vars(module).items():
        if isinstance(value, types.ModuleType):
            yield from bound(value, f"{prefix}.{name}")
        elif not name.startswith("__"):
            yield f"{prefix}.{name}"


def used(source):
    """Dotted names of the C++ modules that a Python file reads."""
    if not re.search(r"_core\b|\bcore\b", source):
        return set()
    tree = ast.parse(source)
    names = {}

    def dotted(node):
        if isinstance(node, ast.Attribute) and (owner := dotted(node.value)):
            return f"{owner}.{node.attr}"
        return names.get(node.id) if isinstance(node, ast.Name) else None

    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and node.module:
            for imported in node.names:
                if f"{node.module}.{imported.name}".startswith(MODULES):
                    names[imported.asname or imported.name] = f"{node.module}.{imported.name}"
        elif isinstance(node, ast.Import):
            for imported in node.names:
                if imported.asname and imported.name.startswith(MODULES):
                    names[imported.asname] = imported.name
    for node in ast.walk(tree):  # aqvc = _core.aqvc
        if isinstance(node, ast.Assign) and (found := dotted(node.value)):
            names |= {to.id: found for to in node.targets if isinstance(to, ast.Name)}
    read = {
        name for node in ast.walk(tree) if isinstance(node, ast.expr) and (name := dotted(node))
    }
    return read | set(names.values())


def used_under(folder):
    return set().union(*map(used, sources(".py", under=folder).values()))


def in_signatures(stub):
    """Names in the annotations of a stub: classes that bindings take or give."""
    return {
        word
        for node in ast.walk(ast.parse(stub))
        if isinstance(node, ast.FunctionDef)
        for annotation in [
            node.returns,
            *(a.annotation for a in node.args.args + node.args.kwonlyargs),
        ]
        if annotation
        for word in re.findall(r"\w+", ast.unparse(annotation))
    }


def test_what_the_core_binds_is_used_by_the_package():
    package = used_under("python/viscache/")
    passed_on = set().union(*(in_signatures(text(path)) for path in paths(".pyi", under=STUBS)))
    names = set(bound(_core, CORE))
    assert len(names) > 100
    unused = {name for name in names - package if name.rpartition(".")[2] not in passed_on}
    assert sorted(unused) == [], "bind what only tests use in tests/core"


def test_what_is_bound_for_tests_is_used_by_tests():
    names = set(bound(testing, TESTING))
    assert len(names) > 50
    assert sorted(names - used_under("tests/")) == [], "no test uses it"


def test_uses_are_found_in_every_form():
    assert used("from viscache import _core\n_core.aqvc.ladder(1)") >= {f"{CORE}.aqvc.ladder"}
    assert used("from viscache import _core\na = _core.aqvc\na.ladder(1)") >= {
        f"{CORE}.aqvc.ladder"
    }
    assert used("from viscache._core import Scene") == {f"{CORE}.Scene"}
    assert used("import viscache._core as core\ncore.Scene") >= {f"{CORE}.Scene"}
    assert used("from core import testing\ntesting.order") >= {f"{TESTING}.order"}
    assert used("from core.testing import order") == {f"{TESTING}.order"}
    assert used("def f(x): return x.aqvc.ladder") == set()
    assert in_signatures("def f(a: viscache._core.Scene) -> list[Camera]: ...") >= {
        "Scene",
        "Camera",
    }


@pytest.mark.parametrize(
    ("skips", "status", "said"),
    [
        (False, 2, "ImportError: tests/core is not built: run scripts/test"),
        (True, 5, "SKIPPED [1] core/__init__.py"),
    ],
)
def test_without_the_module_of_tests_nothing_passes_silently(skips, status, said, tmp_path):
    (tmp_path / "core").mkdir()
    shutil.copy(ROOT / "tests/core/__init__.py", tmp_path / "core")
    (tmp_path / "test_order.py").write_text(
        "from core import testing\n\ndef test_it(): testing.order\n"
    )
    (tmp_path / "pytest.ini").write_text(
        "[pytest]\npythonpath = .\naddopts = -ra --import-mode=importlib\nfilterwarnings = error\n"
    )
    alone = {**os.environ, "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1"}
    environment = {**alone, "VISCACHE_TEST_CORE": "none"}
    if not skips:
        del environment["VISCACHE_TEST_CORE"]
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-p", "no:cacheprovider", tmp_path],
        cwd=tmp_path,
        env=environment,
        capture_output=True,
        text=True,
    )
    assert done.returncode == status and said in done.stdout, done.stdout

"""What only tests use of the C++ module is in `_core._testing`; the package uses all the rest."""

import ast
import re
import types
from collections.abc import Iterator

import viscache._core as core
from codebase.repository import paths, sources, text

CORE = "viscache._core"
TESTING = f"{CORE}._testing."
STUBS = "python/viscache/_core/"


def bound(module: types.ModuleType, prefix: str = CORE) -> Iterator[str]:
    """Dotted names that the C++ module binds."""
    for name, value in vars(module).items():
        if isinstance(value, types.ModuleType):
            yield from bound(value, f"{prefix}.{name}")
        elif not name.startswith("__"):
            yield f"{prefix}.{name}"


def used(source: str) -> set[str]:
    """Dotted names of the C++ module that a Python file reads."""
    tree = ast.parse(source)
    names: dict[str, str] = {}

    def dotted(node: ast.expr) -> str | None:
        if isinstance(node, ast.Attribute) and (owner := dotted(node.value)):
            return f"{owner}.{node.attr}"
        return names.get(node.id) if isinstance(node, ast.Name) else None

    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and node.module:
            for imported in node.names:
                if f"{node.module}.{imported.name}".startswith(CORE):
                    names[imported.asname or imported.name] = f"{node.module}.{imported.name}"
        elif isinstance(node, ast.Import):
            for imported in node.names:
                if imported.asname and imported.name.startswith(CORE):
                    names[imported.asname] = imported.name
    for node in ast.walk(tree):  # aqvc = _core.aqvc
        if isinstance(node, ast.Assign) and (found := dotted(node.value)):
            names |= {to.id: found for to in node.targets if isinstance(to, ast.Name)}
    read = {
        name for node in ast.walk(tree) if isinstance(node, ast.expr) and (name := dotted(node))
    }
    return read | set(names.values())


def used_under(folder: str) -> set[str]:
    return set().union(*map(used, sources(".py", under=folder).values()))


def in_signatures(stub: str) -> set[str]:
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


def test_what_is_outside_testing_is_used_by_the_package() -> None:
    package = used_under("python/viscache/")
    stubs = [path for path in paths(".pyi", under=STUBS) if not path.endswith("/_testing.pyi")]
    passed_on = set().union(*(in_signatures(text(path)) for path in stubs))
    outside = {name for name in bound(core) if not name.startswith(TESTING)}
    assert len(outside) > 100
    unused = {name for name in outside - package if name.rpartition(".")[2] not in passed_on}
    assert sorted(unused) == [], "bind what only tests use in _core._testing"


def test_what_is_in_testing_is_used_by_tests_alone() -> None:
    testing = {name for name in bound(core) if name.startswith(TESTING)}
    assert len(testing) > 50
    assert sorted(testing - used_under("tests/")) == [], "no test uses it"
    assert sorted(testing & used_under("python/viscache/")) == [], "the package uses it"


def test_uses_are_found_in_every_form() -> None:
    assert used("from viscache import _core\n_core.aqvc.ladder(1)") >= {f"{CORE}.aqvc.ladder"}
    assert used("from viscache import _core\na = _core.aqvc\na.ladder(1)") >= {
        f"{CORE}.aqvc.ladder"
    }
    assert used("from viscache._core import Scene") == {f"{CORE}.Scene"}
    assert used("import viscache._core as core\ncore.Scene") >= {f"{CORE}.Scene"}
    assert used("def f(x): return x.aqvc.ladder") == set()
    assert in_signatures("def f(a: viscache._core.Scene) -> list[Camera]: ...") >= {
        "Scene",
        "Camera",
    }

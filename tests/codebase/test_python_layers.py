"""Rooms of the Python packages import downward only, checked in their import statements."""

import ast
import posixpath
import re
from functools import cache
from pathlib import PurePosixPath

import pytest

from codebase.repository import sources

#: Rooms from the ground up: folders of python/viscache, and its single files. A room may import
#: itself, rooms of its own floor and of lower ones. `viscache` stands for the package's own names
#: (`import viscache as vc`).
FLOORS = (
    ("_core",),
    ("base",),
    ("settings",),
    ("scene", "scenes", "frame"),
    ("shot",),
    ("oracles",),
    ("aqvc", "vismap", "vlf", "correlation", "passes", "metrics", "sweeps"),
    ("plots", "report", "notebook", "testing"),
    ("calls",),
    ("viscache",),
    ("commands",),
    ("cli",),
    ("__main__",),
)
RANKS = {room: rank for rank, floor in enumerate(FLOORS) for room in floor}
#: Imports that run back up, with their reasons; they close no circle.
BACK_UP = {
    ("scene", "oracles"): "`Scene.oracle` makes one",
    ("shot", "oracles"): "a frame asks one",
    ("shot", "aqvc"): "a frame takes rows and tables that are kept",
    ("shot", "vismap"): "a frame takes maps",
    ("correlation", "plots"): "`correlation.plots` draws with its colours",
}
SINGLE = {"_core", "calls", "viscache", "cli", "__main__"}
PACKAGE = "python/viscache/"
#: The experiments: beside the library, which knows nothing of them.
LAB = "python/viscache_lab/"
#: Its rooms.
LAB_FLOORS = (
    ("viscache_lab",),
    ("experiment",),
    ("cases", "extremes", "parity"),
    ("bench", "figures"),
    ("commands",),
)
ROOMS = {
    "viscache": RANKS,
    "viscache_lab": {room: rank for rank, floor in enumerate(LAB_FLOORS) for room in floor},
}
#: Files that find modules of their package by name: sub-commands, figures, families of checks.
BY_NAME = (f"{PACKAGE}__init__.py", f"{PACKAGE}cli.py", f"{LAB}experiment/registry.py")


parsed = cache(ast.parse)


def room_of(path):
    package = LAB if path.startswith(LAB) else PACKAGE
    first = PurePosixPath(path).relative_to(package).parts[0]
    return (
        PurePosixPath(package).name if first.startswith("__init__.") else first.removesuffix(".py")
    )


def imported(tree):
    """Line, package and room of every import of ours, also in functions and under TYPE_CHECKING.

    An import for annotations is a dependency, too.
    """
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and node.level == 0:
            module = node.module or ""
            names = [f"{module}.{a.name}" for a in node.names] if module in ROOMS else [module]
        else:
            continue
        for name in names:
            package, *parts = name.split(".")
            if package in ROOMS:
                known = parts and parts[0] in ROOMS[package]
                yield node.lineno, package, parts[0] if known else package


def allowed(ranks, room, target):
    if ranks is RANKS and RANKS[room] == RANKS[target]:
        return target not in SINGLE or room == target
    return room == target or ranks[target] < ranks[room] or (room, target) in BACK_UP


def pairs(files):
    """(room, room that it imports), without the single ones."""
    return {
        (room, target)
        for path, text in files.items()
        for room in [room_of(path)]
        for _, package, target in imported(parsed(text))
        if package == "viscache" and room != target and not SINGLE & {room, target}
    }


def circles(arrows):
    """Rooms from which arrows lead back to themselves."""
    left = set(arrows)
    while ends := {b for _, b in left} - {a for a, _ in left} | {a for a, _ in left} - {
        b for _, b in left
    }:
        left = {(a, b) for a, b in left if not ends & {a, b}}
    return {a for a, _ in left}


def private(tree):
    """Line and name of what a file takes of viscache though it begins with an underscore."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            names = [f"{node.module}.{alias.name}" for alias in node.names]
        else:
            continue
        for name in names:
            if re.match(r"viscache\.(\w+\.)*_", name):
                yield node.lineno, name


def violations(files):
    for path, text in files.items():
        here = PurePosixPath(path).parts[1]
        ranks = ROOMS.get(here, {})
        room = room_of(path) if ranks else here
        if ranks and room not in ranks:
            yield f"{path}: {room} has no place among the floors of {__name__}"
            continue
        tree = parsed(text)
        for line, package, target in imported(tree):
            if here != "viscache_lab" and package == "viscache_lab":
                yield f"{path}:{line}: {here} must not import viscache_lab"
            elif package == here and not allowed(ranks, room, target):
                yield f"{path}:{line}: {room} must not import {target}"
        if here == "viscache_lab":
            for line, name in private(tree):
                yield f"{path}:{line}: the lab imports public names, got {name}"
            for line, source in enumerate(text.splitlines(), 1):
                if re.search(r"\._core\b", source):
                    yield f"{path}:{line}: the lab must not use _core"
        for node in ast.walk(tree):
            if "import_module" not in text or not isinstance(node, ast.Call):
                continue
            if ast.unparse(node.func).endswith("import_module"):
                named = ast.unparse(node.args[0]) if node.args else ""
                if re.search("viscache|__name__", named) and path not in BY_NAME:
                    yield f"{path}:{node.lineno}: import statements name rooms, got {named}"


def test_rooms_import_downward():
    files = sources(".py", under="python/")
    assert len(files) > 300
    assert list(violations(files)) == []


def test_imports_that_run_back_up_have_a_reason():
    arrows = pairs(sources(".py", under=PACKAGE))
    assert {(a, b) for a, b in arrows if RANKS[a] < RANKS[b]} == set(BACK_UP)


def test_modules_close_no_circle():
    files = sources(".py", under=PACKAGE)
    names = {
        path.removeprefix("python/").removesuffix(".py").removesuffix("/__init__").replace("/", ".")
        for path in files
    }
    arrows = set()
    for path, text in files.items():
        here = path.removeprefix("python/").removesuffix(".py").replace("/", ".")
        for node in ast.walk(parsed(text)):
            if isinstance(node, ast.ImportFrom):
                for alias in node.names:
                    whole = f"{node.module}.{alias.name}"
                    arrows.add((here, whole if whole in names else node.module or ""))
    assert circles(arrows) == set()


def test_a_circle_is_found():
    assert circles({("a", "b"), ("b", "c"), ("a", "c")}) == set()
    assert circles({("a", "b"), ("b", "c"), ("c", "b"), ("c", "d")}) == {"b", "c"}


@pytest.mark.parametrize("package", [PACKAGE, LAB])
def test_every_room_of_the_table_is_there(package):
    present = {room_of(path) for path in sources(".py", ".pyi", under=package)}
    assert set(ROOMS[PurePosixPath(package).name]) == present


BENCH = "../viscache_lab/bench/rays.py"


@pytest.mark.parametrize(
    ("path", "line", "expected"),
    [
        ("frame/frame.py", "from viscache.shot.render import render", "frame must not import shot"),
        ("base/files.py", "import viscache.scenes.room", "base must not import scenes"),
        ("settings/by_name.py", "import viscache as vc", "settings must not import viscache"),
        ("settings/by_name.py", "from viscache import Aqvc", "settings must not import viscache"),
        ("vlf/field.py", "def f():\n    from viscache.plots import g", "vlf must not import plots"),
        ("vlf/field.py", "if TYPE_CHECKING:\n    from viscache.plots import g", "vlf must not"),
        ("cli.py", "from viscache_lab.figures import FIGURES", "must not import viscache_lab"),
        ("../pytest_viscache/__init__.py", "import viscache_lab", "must not import viscache_lab"),
        (BENCH, "from viscache_lab.figures.page import html", "bench must not import figures"),
        (BENCH, "from viscache import _core", "the lab imports public names"),
        (BENCH, "from viscache.shot.render import _part", "the lab imports public names"),
        (BENCH, "scene._core.radius", "the lab must not use _core"),
        (
            "scenes/sources.py",
            'importlib.import_module("viscache.scenes")',
            "import statements name rooms",
        ),
        ("shelf.py", "", "shelf has no place among the floors"),
        # Allowed
        ("shot/render.py", "from viscache.scene import Scene", None),
        ("scene/scene.py", "from viscache.scene.coplanar import coplanar_share", None),
        ("commands/render.py", "import viscache as vc", None),
        ("cli.py", 'importlib.import_module(f"viscache.commands.{name}")', None),
        ("metrics/__init__.py", 'importlib.import_module("flip_evaluator")', None),
        ("settings/rays.py", "from viscache import _core", None),
        (BENCH, "import viscache as vc", None),
        (BENCH, "from viscache.shot.render import render", None),
        ("scene/scene.py", "from viscache.oracles.oracle import Oracle", None),
    ],
)
def test_an_import_that_climbs_is_found_and_no_other(path, line, expected):
    found = list(violations({posixpath.normpath(PACKAGE + path): line + "\n"}))
    assert len(found) == (expected is not None)
    assert all(expected in says for says in found)

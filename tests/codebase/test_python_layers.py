"""Rooms of the Python package import downward only, checked in its import statements."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator, Mapping
from pathlib import PurePosixPath

import pytest

from codebase.repository import sources

#: Rooms from the ground up: a folder or a file of python/viscache. A room may import itself and
#: rooms of lower floors. `viscache` stands for the package's own names (`import viscache as vc`).
FLOORS: tuple[tuple[str, ...], ...] = (
    ("_core", "real_numbers"),
    (
        "array_digests",
        "array_output",
        "audit_result",
        "files",
        "progress",
        "provenance",
        "sharing",
        "tonemap",
        "workers",
    ),
    ("formats", "frame_html", "live_view", "netcdf", "settings"),
    ("oracles",),
    ("emitted_light", "exact_cost", "frame", "frame_memory", "scene", "variance"),
    ("metrics", "notebook", "scenes", "temporal"),
    ("sources",),
    ("aqvc_rows", "aqvc_table", "combinations", "vismap", "vlf", "voxel_counts"),
    ("audited",),
    ("render",),
    ("shot",),
    ("progressive_state",),
    ("progressive",),
    ("connections", "over_time", "thumbnails", "tiles", "travelling"),
    ("query_record",),
    ("sweeps",),
    ("plots",),
    ("correlation", "report"),
    ("testing",),
    ("viscache",),
    ("cases", "extremes", "parity"),
    ("bench", "figures"),
    ("commands", "demo"),
    ("cli",),
    ("__main__",),
)
RANKS = {room: rank for rank, floor in enumerate(FLOORS) for room in floor}
PACKAGE = "python/viscache/"
#: Files that find modules of the package by name: sub-commands, figures, families of checks.
BY_NAME = tuple(
    f"{PACKAGE}{file}"
    for file in ("cli.py", "figures/__init__.py", "extremes/families/__init__.py")
)


def room_of(path: str) -> str:
    """Which room a file of the package belongs to."""
    first = PurePosixPath(path).relative_to(PACKAGE).parts[0]
    return "viscache" if first == "__init__.py" else first.removesuffix(".py")


def imported(tree: ast.Module) -> Iterator[tuple[int, str]]:
    """Line and room of every import of the package, also in functions and under TYPE_CHECKING.

    An import for annotations is a dependency, too.
    """
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and node.level == 0:
            module = node.module or ""
            one_by_one = module == "viscache"
            names = [f"{module}.{a.name}" for a in node.names] if one_by_one else [module]
        else:
            continue
        for name in names:
            parts = name.split(".")
            if parts[0] == "viscache":
                room = parts[1] if len(parts) > 1 else "viscache"
                yield node.lineno, room if room in RANKS else "viscache"


def violations(files: Mapping[str, str]) -> Iterator[str]:
    for path, text in files.items():
        room = room_of(path)
        if room not in RANKS:
            yield f"{path}: {room} has no place among the floors of {__name__}"
            continue
        tree = ast.parse(text)
        for line, target in imported(tree):
            if target != room and RANKS[target] >= RANKS[room]:
                yield f"{path}:{line}: {room} must not import {target}"
        for node in ast.walk(tree):
            if isinstance(node, ast.ImportFrom) and node.level > 0:
                yield f"{path}:{node.lineno}: imports name the package, got a relative one"
            if "import_module" not in text or not isinstance(node, ast.Call):
                continue
            if ast.unparse(node.func).endswith("import_module"):
                named = ast.unparse(node.args[0]) if node.args else ""
                if re.search("viscache|__name__", named) and path not in BY_NAME:
                    yield f"{path}:{node.lineno}: import statements name rooms, got {named}"


def test_rooms_import_downward() -> None:
    files = sources(".py", under=PACKAGE)
    assert len(files) > 100
    assert list(violations(files)) == []


def test_every_room_of_the_table_is_there() -> None:
    present = {room_of(path) for path in sources(".py", ".pyi", under=PACKAGE)}
    assert set(RANKS) == present


@pytest.mark.parametrize(
    ("path", "line", "expected"),
    [
        ("frame.py", "from viscache.render import render", "frame must not import render"),
        ("scene/scene.py", "import viscache.scenes.room", "scene must not import scenes"),
        ("scene/scene.py", "from viscache import sweeps", "scene must not import sweeps"),
        ("settings/by_name.py", "import viscache as vc", "settings must not import viscache"),
        ("settings/by_name.py", "from viscache import Aqvc", "settings must not import viscache"),
        (
            "vlf/field.py",
            "def f():\n    from viscache.render import g",
            "vlf must not import render",
        ),
        ("vlf/field.py", "if TYPE_CHECKING:\n    from viscache.render import g", "vlf must not"),
        (
            "bench/rays.py",
            "from viscache.figures.page import html",
            "bench must not import figures",
        ),
        ("figures/page.py", "import viscache.bench", "figures must not import bench"),
        (
            "sources.py",
            'importlib.import_module("viscache.scenes")',
            "import statements name rooms",
        ),
        ("scenes/room.py", "from . import shapes", "got a relative one"),
        ("shelf.py", "", "shelf has no place among the floors"),
    ],
)
def test_an_import_that_climbs_is_found(path: str, line: str, expected: str) -> None:
    found = list(violations({PACKAGE + path: line + "\n"}))
    assert len(found) == 1
    assert expected in found[0]


@pytest.mark.parametrize(
    ("path", "line"),
    [
        ("render.py", "from viscache.scene import Scene"),
        ("scene/scene.py", "from viscache.scene.coplanar import coplanar_share"),
        ("commands/render.py", "import viscache as vc"),
        ("cli.py", 'importlib.import_module(f"viscache.commands.{name}")'),
        ("metrics.py", 'importlib.import_module("flip_evaluator")'),
        ("settings/rays.py", "from viscache import _core"),
    ],
)
def test_an_import_that_goes_down_is_not_reported(path: str, line: str) -> None:
    assert list(violations({PACKAGE + path: line + "\n"})) == []

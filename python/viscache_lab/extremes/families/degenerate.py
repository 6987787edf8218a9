"""Triangles without area, needles, coplanar copies: what has no area has no effect."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache, partial

import numpy as np

import viscache as vc
from viscache_lab.experiment import FAMILIES, Case
from viscache_lab.extremes import scenes
from viscache_lab.extremes.pictures import METHODS, Method, bad_pixels, differing, picture, rel_l1
from viscache_lab.extremes.scenes import Arrays

#: One of each kind of answer; forms of the cache see the same triangles.
CHOSEN = (
    "exact by Embree",
    "exact by BSP",
    "exact by the field",
    "exact by shafts",
    "exact products",
    "quantized cache",
    'quantized cache "paper"',
    "shadow maps",
    "NEE++",
    "visibility maps",
)


@FAMILIES.add("degenerate", "triangles without area, needles, coplanar copies")
def degenerate(full: bool) -> Iterator[Case]:
    methods = METHODS if full else {name: METHODS[name] for name in CHOSEN}
    for name, method in methods.items():
        for kind in ("zero-area triangles", "a line", "a point"):
            yield Case(
                name=f"{name}, {kind}: pixels that differ from those without",
                measure=partial(_differing, method, kind),
                why="no ray hits what has no area",
            )
        for kind in ("needles 1e-10 wide", "needles 1e-20 wide"):
            yield Case(
                name=f"{name}, {kind}: rel_l1 against the scene without",
                measure=partial(_change, method, kind),
                limit=1e-6,
                why="no ray meets what is so narrow; one pixel would be 1e-4",
            )
        yield Case(
            name=f"{name}, walls 50 times in one place: pixels that differ from once",
            measure=partial(_differing, method, "50 copies"),
            why="equal triangles have equal hits",
        )
        yield Case(
            name=f"{name}, a copy of each wall 1e-7 away: pixels that are not finite",
            measure=partial(_bad, method),
            why="a ray may start behind the copy, and is dark then",
        )


def dust(kind: str) -> list[Arrays]:
    """What is added to the floor and the table."""
    corners, _ = scenes.floor()
    if kind == "zero-area triangles":
        return [(corners, np.array([[0, 0, 0], [1, 1, 2], [0, 1, 0], [2, 2, 2]], np.uint32))]
    one = np.array([[0, 1, 2]], np.uint32)
    if kind == "a line":
        return [(np.array([[0, 0.3, 0], [0.1, 0.3, 0], [0.2, 0.3, 0]]), one)]
    if kind == "a point":
        return [(np.full((3, 3), 0.25), one)]
    if kind.startswith("needles"):
        width = float(kind.split()[1])
        rng = np.random.default_rng(1)
        ends = rng.uniform(-1, 1, (20, 2, 3)) * [1, 0.2, 1] + [0, 0.35, 0]
        third = ends[:, 0] + [width, 0, 0]
        triangles = np.concatenate([ends, third[:, None]], axis=1)
        return [(t, one) for t in triangles]
    copies = [scenes.floor(), scenes.table()]
    if kind == "50 copies":
        return copies * 49
    return [(places - [0, 1e-7, 0], quads) for places, quads in copies]


@cache
def _scene(kind: str = "") -> vc.Scene:
    parts = [scenes.floor(), scenes.table()]
    return scenes.with_parts(*parts, *(dust(kind) if kind else []))


def _bad(method: Method) -> float:
    return bad_pixels(picture(_scene("a copy 1e-7 away"), method))


def _differing(method: Method, kind: str) -> float:
    return differing(picture(_scene(kind), method), picture(_scene(), method))


def _change(method: Method, kind: str) -> float:
    return rel_l1(picture(_scene(kind), method), picture(_scene(), method))

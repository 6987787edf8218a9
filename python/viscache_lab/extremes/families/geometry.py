"""What has no area has no effect; scenes without triangles; scenes that no camera sees."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import cache, partial
from itertools import product
from typing import Any

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
NO_AREA = "no ray hits what has no area"
COPIES = "equal triangles have equal hits"
BEHIND = "a ray may start behind the copy, and is dark then"
NARROW = "no ray meets what is so narrow; one pixel would be 1e-4"
#: What is added, what of it is measured, and the limit with its reason.
ROWS = (
    ("zero-area triangles", "pixels that differ from those without", differing, 0, NO_AREA),
    ("a line", "pixels that differ from those without", differing, 0, NO_AREA),
    ("a point", "pixels that differ from those without", differing, 0, NO_AREA),
    ("needles 1e-10 wide", "rel_l1 against the scene without", rel_l1, 1e-6, NARROW),
    ("needles 1e-20 wide", "rel_l1 against the scene without", rel_l1, 1e-6, NARROW),
    ("walls 50 times in one place", "pixels that differ from once", differing, 0, COPIES),
    ("a copy of each wall 1e-7 away", "pixels that are not finite", None, 0, BEHIND),
)


@FAMILIES.add("degenerate", "triangles without area, needles, coplanar copies")
def degenerate(full: bool) -> Iterator[Case]:
    methods = METHODS if full else {name: METHODS[name] for name in CHOSEN}
    for (name, method), (kind, what, measure, limit, why) in product(methods.items(), ROWS):
        yield Case(
            name=f"{name}, {kind}: {what}",
            measure=partial(_with, kind, method, measure),
            limit=limit,
            why=why,
        )


def _with(
    kind: str, method: Method, measure: Callable[[vc.Frame, vc.Frame], float] | None
) -> float:
    """A measure of the frame with an addition against that without; by default bad pixels of it."""
    frame = picture(_scene(kind), method)
    return measure(frame, picture(_scene(), method)) if measure else bad_pixels(frame)


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
    if kind.startswith("walls"):
        return copies * 49
    return [(places - [0, 1e-7, 0], quads) for places, quads in copies]


@cache
def _scene(kind: str = "") -> vc.Scene:
    parts = [scenes.floor(), scenes.table()]
    return scenes.with_parts(*parts, *(dust(kind) if kind else []))


CASTERS: dict[str, Any] = {
    "Embree": vc.Embree(),
    "BSP": vc.Bsp(),
    "the field": vc.Vlf(n_directions=33, n_tiles=8),
}


@FAMILIES.add("empty", "scenes without triangles, and triangles behind the camera")
def empty(full: bool) -> Iterator[Case]:
    for name, rays in CASTERS.items():
        yield Case(
            name=f"{name}, no triangles: rays that hit, segments that are blocked",
            measure=partial(_hits, rays),
            why="there is nothing to hit",
        )
    for name, method in METHODS.items():
        for kind in ("no triangles", "triangles behind the camera"):
            yield Case(
                name=f"{name}, {kind}: pixels that are not the sky",
                measure=partial(_not_sky, method, kind),
                why="every ray of the camera leaves",
            )
    yield Case(
        name="no triangles: scenes without a warning",
        measure=lambda: float(not _unseen("no triangles").warnings),
        why="an empty scene is most often a mistake",
    )


def _unseen(kind: str) -> vc.Scene:
    parts = [] if kind == "no triangles" else [scenes.floor(1.0), scenes.table()]
    away = ((0.0, 9.0, 0.0), (0.0, 10.0, 0.1), 40.0)
    return scenes.with_parts(*parts, camera=away)


def _hits(rays: Any) -> float:
    scene, rng = _unseen("no triangles"), np.random.default_rng(1)
    x, y = rng.normal(size=(2, 100, 3))
    hit = np.isfinite(scene.intersect(x, y, rays=rays, threads=1).t)
    shadow = scene.occluded(x, y, rays=rays, threads=1)
    return float(hit.sum() + shadow.sum() + (~scene.visible(x, y, rays=rays, threads=1)).sum())


def _not_sky(method: Method, kind: str) -> float:
    frame = picture(_unseen(kind), method, **{"env": (0.25, 0.5, 1.0)})
    return float((np.abs(frame.image - np.array([0.25, 0.5, 1.0])) > 1e-6).any(axis=-1).sum())

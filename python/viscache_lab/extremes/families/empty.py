"""Scenes without triangles, and scenes that the camera does not see."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import Any

import numpy as np

import viscache as vc
from viscache_lab.experiment import FAMILIES, Case
from viscache_lab.extremes import scenes
from viscache_lab.extremes.pictures import METHODS, Method, picture

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
        measure=lambda: float(not _scene("no triangles").warnings),
        why="an empty scene is most often a mistake",
    )


def _scene(kind: str) -> vc.Scene:
    parts = [] if kind == "no triangles" else [scenes.floor(1.0), scenes.table()]
    away = ((0.0, 9.0, 0.0), (0.0, 10.0, 0.1), 40.0)
    return scenes.with_parts(*parts, camera=away)


def _hits(rays: Any) -> float:
    scene, rng = _scene("no triangles"), np.random.default_rng(1)
    x, y = rng.normal(size=(2, 100, 3))
    hit = np.isfinite(scene.intersect(x, y, rays=rays, threads=1).t)
    shadow = scene.occluded(x, y, rays=rays, threads=1)
    return float(hit.sum() + shadow.sum() + (~scene.visible(x, y, rays=rays, threads=1)).sum())


def _not_sky(method: Method, kind: str) -> float:
    frame = picture(_scene(kind), method, **{"env": (0.25, 0.5, 1.0)})
    return float((np.abs(frame.image - np.array([0.25, 0.5, 1.0])) > 1e-6).any(axis=-1).sum())

"""1, 2, 3 and 7 threads: the same bytes of every method."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import numpy as np

import viscache as vc
from viscache_lab.experiment import FAMILIES, Case
from viscache_lab.extremes import scenes
from viscache_lab.extremes.pictures import METHODS, Method, picture, unequal

COUNTS = (1, 2, 3, 7)
WHY = "a tile is the unit of work; random numbers do not know threads"


@FAMILIES.add("threads", "1, 2, 3 and 7 threads")
def threads(full: bool) -> Iterator[Case]:
    for name, method in METHODS.items():
        # Larger than a tile, so that there are several
        size = (160, 100) if full else (100, 60)
        yield Case(
            name=f"{name}: frames whose bytes differ",
            measure=partial(_frames, method, size=(48, 32) if method.maps else size),
            why=WHY,
        )
    paths = {"integrator": vc.Bdpt(max_depth=3), "visibility": vc.Aqvc(c_e=6)}
    for what, measure in {
        "bidirectional paths: frames whose bytes differ": partial(_frames, None, **paths),
        "correlation: tables that differ": partial(_others, _correlation),
        "records of maps: caches that differ": partial(_others, _records),
    }.items():
        yield Case(name=what, measure=measure, why=WHY)


def _frames(method: Method | None, **given: Any) -> float:
    return unequal([picture(scenes.lit_box(), method, threads=t, **given) for t in COUNTS])


def _others(answers: Callable[[int], bytes]) -> float:
    """How many numbers of threads give other bytes than one."""
    first, *others = map(answers, COUNTS)
    return float(sum(other != first for other in others))


def _correlation(threads: int) -> bytes:
    given: dict[str, Any] = {"n_points": 400, "map_size": 16, "pairs": "all", "seed": 3}
    table = vc.correlation.measure(scenes.lit_box(), threads=threads, **given)
    return np.asarray(table["mean"]).tobytes()


def _records(threads: int) -> bytes:
    cache = vc.VisibilityMapCache(scenes.lit_box(), vc.MapSettings(n_startup=50))
    cache.update(size=(48, 32), threads=threads)
    made = cache.records()
    return made.bits.tobytes() + made.positions.tobytes()

"""1, 2, 3 and 7 threads: the same bytes of every method."""

from __future__ import annotations

from collections.abc import Iterator
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
            measure=partial(_differing, method, (48, 32) if method.maps else size),
            why=WHY,
        )
    yield Case(name="bidirectional paths: frames whose bytes differ", measure=_paths, why=WHY)
    yield Case(name="correlation: tables that differ", measure=_correlation, why=WHY)
    yield Case(name="records of maps: caches that differ", measure=_records, why=WHY)


def _differing(method: Method, size: tuple[int, int]) -> float:
    return unequal([picture(scenes.lit_box(), method, size=size, threads=t) for t in COUNTS])


def _paths() -> float:
    given: dict[str, Any] = {"integrator": vc.Bdpt(max_depth=3), "visibility": vc.Aqvc(c_e=6)}
    return unequal([picture(scenes.lit_box(), threads=t, **given) for t in COUNTS])


def _correlation() -> float:
    tables = [
        vc.correlation.measure(
            scenes.lit_box(), n_points=400, map_size=16, pairs="all", seed=3, threads=t
        )
        for t in COUNTS
    ]
    return float(sum(not t["mean"].equals(tables[0]["mean"]) for t in tables[1:]))


def _records() -> float:
    made = []
    for t in COUNTS:
        cache = vc.VisibilityMapCache(scenes.lit_box(), vc.MapSettings(n_startup=50))
        cache.update(size=(48, 32), threads=t)
        made.append(cache.records())
    return float(
        sum(
            not (
                np.array_equal(r.bits, made[0].bits)
                and np.array_equal(r.positions, made[0].positions)
            )
            for r in made[1:]
        )
    )

"""The unit of length: a scene a millionth or a million times as large gives the same picture."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import Any

import viscache as vc
from viscache_lab.experiment import FAMILIES, Case
from viscache_lab.extremes import scenes
from viscache_lab.extremes.moved import moved
from viscache_lab.extremes.pictures import (
    METHODS,
    Method,
    against_unmoved,
    differing,
    error_of,
    rel_l1,
)

#: Errors of two grids or of two draws, means of three seeds: measured 0.5 … 1.4.
RATIO = (0.4, 2.0)
EXACT = "a product with a power of two is exact, so every number of the frame is"
ROUNDED = "coordinates are rounded by 6e-8 of their size; measured 1e-6 at most, 5 times that"
REDRAWN = "other cells or random numbers; measured 0.66 … 1.3"


@FAMILIES.add("scales", "the same picture in any unit of length")
def scales(full: bool) -> Iterator[Case]:
    for name, method in METHODS.items():
        if not method.noisy:
            for power in (20, -20):
                yield Case(
                    name=f"{name}, 2^{power} times as large: pixels that differ",
                    measure=partial(against_unmoved, differing, method, scale=2.0**power),
                    why=EXACT,
                )
    factors = (1e6, 1e-6, 1e3, 1e-3, 0.37, 2e5, 3e-5) if full else (1e6, 1e-6)
    for name, method in METHODS.items():
        for factor in factors:
            words = f"{name}, {factor:g} times as large"
            if method.noisy:
                yield Case(
                    name=f"{words}: error over that of the unit scene",
                    measure=partial(error_ratio, method, scale=factor),
                    limit=RATIO,
                    why=REDRAWN,
                )
            else:
                yield Case(
                    name=f"{words}: rel_l1",
                    measure=partial(against_unmoved, rel_l1, method, scale=factor),
                    limit=5e-6,
                    why=ROUNDED,
                )
    for factor in (1e-10, 1e11):
        yield Case(
            name=f"{factor:g} times as large: scenes without a warning",
            measure=partial(_silent, factor),
            why="pictures hold from 1e-6 to 1e9; what lies beyond is warned of",
        )


def _silent(scale: float) -> float:
    return float(not moved(scenes.lit_box(), scale=scale).warnings)


def error_ratio(
    method: Method, base: vc.Scene | None = None, seeds: int = 3, **transform: Any
) -> float:
    """The mean error of a method in the moved box over that in the box, or in `base`."""
    other, base = moved(scenes.lit_box(), **transform), base or scenes.lit_box()
    there, here = (
        sum(error_of(scene, method, seed=seed) for seed in range(seeds)) for scene in (other, base)
    )
    return there / here

"""The distance from the origin: single precision loses digits, and no method loses more."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np

import viscache as vc
from viscache_lab.experiment import FAMILIES, Case
from viscache_lab.extremes import scenes
from viscache_lab.extremes.families.scales import RATIO, REDRAWN, error_ratio
from viscache_lab.extremes.moved import moved
from viscache_lab.extremes.pictures import METHODS, against_unmoved, picture, rel_l1

#: The direction of the offset: no axis, no diagonal.
AWAY = np.array([1.0, 0.7, -0.4])
#: Sizes from the origin of scenes that say where they are.
FAR = 1e6
#: rel_l1 per size of the scene of offset.
PER_SIZE = 4e-6
GROWS = (
    "coordinates are rounded by 6e-8 of the offset, and rays start 1e-6 of it off surfaces; "
    "measured 1.1e-6 per size, 4 times that"
)
MAP_BITS = "a bit of a map that flips changes a blend: measured 1e-3, twice that"
#: With an origin beside the scene, coordinates are rounded once, as at another scale.
AT_HOME = 5e-6
HOME_WHY = "the origin is subtracted in double: 1e-16 of the offset is lost; measured 0 to 3e-7"
#: The energy that may be wrong in a scene that is not warned of.
SILENT = 5e-3


@FAMILIES.add("offsets", "scenes far from the origin")
def offsets(full: bool) -> Iterator[Case]:
    sizes = (1, 10, 100, 300, 1000) if full else (1, 1000)
    for name, method in METHODS.items():
        for k in sizes:
            words = f"{name}, {k} sizes from the origin"
            if method.noisy:
                yield Case(
                    name=f"{words}: error over that at the origin",
                    measure=partial(error_ratio, method, shift=shift(k)),
                    limit=RATIO,
                    why=REDRAWN,
                )
                continue
            limit, why = PER_SIZE * k, GROWS
            if method.maps and k >= 100:
                limit, why = max(limit, 2e-3), MAP_BITS
            yield Case(
                name=f"{words}: rel_l1",
                measure=partial(against_unmoved, rel_l1, method, shift=shift(k)),
                limit=limit,
                why=why,
            )
    far = tuple(shift(FAR).tolist())
    chosen = METHODS if full else ("exact by Embree", "quantized cache", "shadow maps")
    for name in chosen:
        if not METHODS[name].noisy:
            yield Case(
                name=f"{name}, {FAR:g} sizes from the origin, with origin= there: rel_l1",
                measure=partial(against_unmoved, rel_l1, METHODS[name], shift=far, origin=far),
                limit=2e-3 if METHODS[name].maps else AT_HOME,
                why=HOME_WHY,
            )
    for k in (2000, 4000, 7000, 9000, 20_000, 100_000):
        yield Case(
            name=f"{k} sizes from the origin: energy that is wrong without a warning",
            measure=partial(_silent, k),
            limit=SILENT,
            why="what is wrong by more than half a percent must be warned of",
        )


def shift(sizes: float, scene: vc.Scene | None = None) -> np.ndarray:
    """The offset of so many sizes of a scene, the lit box by default."""
    bounds = (scene or scenes.lit_box()).bounds
    return AWAY * sizes * float(np.ptp(bounds, axis=0).max())


def _silent(sizes: float) -> float:
    """The energy that is missing or too much, 0 where the scene is warned of."""
    worst = 0.0
    for scene in (scenes.lit_box(), scenes.cube()):
        far = moved(scene, shift=shift(sizes, scene))
        if not far.warnings:
            energy = picture(far).image.astype(float).sum() / picture(scene).image.sum()
            worst = max(worst, abs(energy - 1))
    return float(worst)

"""Pictures of one pixel, one column and one row, and 10⁵ samples of a pixel."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache, partial
from typing import Any

import numpy as np

import viscache as vc
from viscache_lab.experiment import FAMILIES, Case
from viscache_lab.extremes import scenes
from viscache_lab.extremes.pictures import (
    METHODS,
    SHARED,
    bad_pixels,
    differing,
    lit,
    one,
    picture,
    two,
)

#: Samples of a pixel.
MANY = 100_000
FORMS: dict[str, dict[str, Any]] = {
    "waves": {},
    "pairs": {"paper": vc.PaperForm(form="pairs", storage="exact")},
}


@FAMILIES.add("picture_sizes", "1×1 and 1×8192 pictures, 10⁵ samples per pixel")
def picture_sizes(full: bool) -> Iterator[Case]:
    sizes = [(1, 1), (1, 8192), (8192, 1)] + ([(2, 4096), (257, 3)] if full else [])
    for name, method in METHODS.items():
        if method.noisy and not full and name != "NEE++":
            continue
        # Maps of 8192 pixels far apart are as many records
        for size in sizes[:1] if method.maps and not full else sizes:
            yield Case(
                name=f"{name}, {size[0]}×{size[1]}: pixels that are not finite",
                measure=partial(one, bad_pixels, method=name, size=size),
                why="tiles of one pixel or one column are tiles",
            )
    for name, form in FORMS.items():
        fine = {"visibility": vc.Aqvc(c_e=1e-3, exact_groups=(), **form)}
        for size in sizes:
            yield Case(
                name=f"vanishing cells, {name}, {size[0]}×{size[1]}: pixels that differ from exact",
                measure=partial(two, differing, fine, integrator=SHARED, size=size),
                why="a cell that holds one eye point approximates nothing",
            )
    for name, expected in {"coverage": 1.0, "depth": 5.0, "albedo": 0.5}.items():
        yield Case(
            name=f"{MANY} samples: error of the {name}",
            measure=partial(_layer, name, expected),
            limit=1e-6,
            why="a mean of equal numbers; the result is rounded by 6e-8",
        )
    yield Case(
        name=f"{MANY} samples: standard errors between them and the mean of 100 parts",
        measure=_drift,
        limit=4,
        why="sums of many samples do not drift; 1 in 16000 by chance",
    )


@cache
def _from_above() -> vc.Scene:
    """A floor seen from 5 above, through so narrow a pixel that all depths are equal."""
    above = ((0.1, 5.0, 0.2), (0.1, 0.0, 0.2), 0.01)
    description = scenes.described(scenes.floor(), lights=())
    description.add_camera(above[0], above[1], up=(0, 0, 1), fov_deg=above[2])
    return vc.Scene.from_description(description)


@cache
def _many() -> vc.Frame:
    return picture(_from_above(), size=(1, 1), spp=MANY, camera=1)


def _layer(name: str, expected: float) -> float:
    found = np.asarray(_many().layers[name], float)
    return float(np.abs(found - expected).max() / expected)


def _drift() -> float:
    """Of the energy of two pixels, between one frame and 100 of other samples."""
    given: dict[str, Any] = {
        "size": (2, 1),
        "integrator": vc.Direct(n_area=1, n_brdf=0, n_environment=0),
    }
    part = MANY // 100

    def energy(**more: Any) -> float:
        return float(lit(**given, **more).image.astype(float).mean())

    parts = [energy(spp=part, first_sample=MANY + k * part) for k in range(100)]
    spread = np.std(parts, ddof=1) * np.sqrt(2 / len(parts))
    return float(abs(np.mean(parts) - energy(spp=MANY)) / spread)

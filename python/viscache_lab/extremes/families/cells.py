"""Cells of every size, and normals and planes on the edges of bins and cells."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import cache, partial
from itertools import product

import numpy as np

import viscache as vc
from viscache_lab.experiment import FAMILIES, Case
from viscache_lab.extremes import scenes
from viscache_lab.extremes.moved import moved
from viscache_lab.extremes.pictures import (
    BRIGHT,
    DIRECT,
    SHARED,
    differing,
    outside,
    picture,
    rel_l1,
    two,
)

#: Normals on axes, between two, on a diagonal, and on the seams of the octahedral map.
NORMALS = {
    "on an axis": (0, 1, 0),
    "on another axis": (1, 0, 0),
    "at 45°": (0, 1, 1),
    "at 45° to two axes": (1, 1, 0),
    "on a diagonal": (1, 1, 1),
    "on the octahedral seam": (1, 0, -2),
    "on the other octahedral seam": (-2, 3, 0),
}
#: Rays with noise over rays without. Measured 0.88 … 1.09.
SAME_RAYS = (0.85, 1.15)
LIMIT_WHY = "grids are shifted by irrational amounts, and bins are rounded to; measured below 15 %"


@FAMILIES.add("bins", "normals and planes on the edges of bins and cells")
def bins(full: bool) -> Iterator[Case]:
    modes = ("round", "octahedral") if full else ("round",)
    for place, normal in NORMALS.items():
        for mode in modes:
            for c_n in (2, 4, 6, 8, 16) if full else (2, 8):
                for noise in (1e-7, 1e-6) if full else (1e-7,):
                    yield Case(
                        name=f"a plane {place}, {mode}, c_n = {c_n}, noise {noise:g}: "
                        "rays over those without noise",
                        measure=partial(more_rays, normal, noise, c_n, mode),
                        limit=SAME_RAYS,
                        why=LIMIT_WHY,
                    )


@cache
def plane(normal: tuple[int, int, int], noise: float) -> vc.Scene:
    """A plane of 40 × 40 squares through the centre of the scene, a table over it, a light."""
    steps = np.linspace(-2, 2, 41)
    x, z = (a.ravel() for a in np.meshgrid(steps, steps))
    a, b, c, d = ((np.arange(40)[:, None] * 41 + np.arange(40)).ravel() + k for k in (0, 41, 42, 1))
    cells = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)]).astype(np.uint32)
    ground = np.stack([x, 0 * x, z], axis=1), cells
    # Two specks make the centre of the bounds lie in the plane
    one = np.array([[0, 1, 2]], np.uint32)
    specks = [(np.array([[0, h, 0], [1e-3, h, 0], [0, h, 1e-3]]), one) for h in (-2.0, 2.0)]
    made = scenes.with_parts(ground, *specks, scenes.table(), camera=((0, 2, 3), (0, 0, 0), 45))
    return moved(made, rotation=_onto(normal), noise=noise)


def _onto(normal: tuple[int, int, int]) -> np.ndarray:
    """A rotation (3, 3) of the y axis onto a normal."""
    y = np.array(normal) / np.linalg.norm(normal)
    side = np.cross(y, [0, 0, 1] if abs(y[2]) < 0.9 else [1, 0, 0])
    side /= np.linalg.norm(side)
    return np.stack([side, y, np.cross(side, y)], axis=1)


def more_rays(
    normal: tuple[int, int, int], noise: float, c_n: int, mode: str, **paper: object
) -> float:
    """Rays of the plane with noise over rays of the plane without."""
    form = vc.PaperForm(normal_mode=mode, **paper)  # type: ignore[arg-type]
    cache = vc.Aqvc(c_e=6, c_n=c_n, exact_groups=(), refinement="off", paper=form)
    rays = [
        picture(plane(normal, shaken), visibility=cache, size=(80, 50)).counters["rays"]
        for shaken in (noise, 0.0)
    ]
    return float(rays[0] / rays[1])


#: Point and directional lights alone.
POINTS = vc.Direct(n_area=0, n_environment=0, n_brdf=0)
#: Presets and forms, all light groups through the cache.
FORMS: dict[str, vc.Aqvc] = {
    "default": vc.Aqvc(exact_groups=()),
    "fast": vc.Aqvc(preset="fast", exact_groups=()),
    "paper": vc.Aqvc(preset="paper"),
    "as_printed": vc.Aqvc(preset="as_printed"),
    "pairs, full keys": vc.Aqvc(exact_groups=(), paper=vc.PaperForm(form="pairs", storage="exact")),
    "scale-free": vc.Aqvc(exact_groups=(), paper=vc.PaperForm(scale_free=True)),
}


@FAMILIES.add("cell_sizes", "C_E from 1e-3 to 1e4, presets and forms")
def cell_sizes(full: bool) -> Iterator[Case]:
    for name, cache_ in FORMS.items():
        # Cells of virtual lights that are quantized as surfaces do not depend on C_E
        light = POINTS if cache_.paper.vpl_key == "surface" else SHARED
        for c_e in (1e-3, 1e-9, 1e-30):
            fine = {"visibility": replace(cache_, c_e=c_e)}
            yield Case(
                name=f"{name}, C_E = {c_e:g}: pixels that differ from exact ones",
                measure=partial(two, differing, fine, integrator=light),
                why="a cell that holds one eye point approximates nothing",
            )
        for c_e, integrator in product((1e2, 1e4, 1e9, 1e30), (SHARED, DIRECT)):
            coarse = {"visibility": replace(cache_, c_e=c_e)}
            yield Case(
                name=f"{name}, C_E = {c_e:g}, {type(integrator).__name__}: "
                "pixels not between black and unshadowed",
                measure=partial(two, outside, coarse, BRIGHT, integrator=integrator),
                why="a cache of bits answers visible or occluded",
            )
        yield Case(
            name=f"{name}: error at C_E = 1 over that at C_E = 48",
            measure=partial(_grows, cache_, 3),
            limit=0.35,
            why="cells of 1 pixel instead of 48: measured 0.03 … 0.17, twice that",
        )


def _grows(cache_: vc.Aqvc, seeds: int) -> float:
    def error(c_e: float) -> float:
        mine = {"visibility": replace(cache_, c_e=c_e)}
        error = partial(two, rel_l1, mine, integrator=SHARED, size=(96, 64))
        return sum(error(seed=seed) for seed in range(seeds))

    return error(1.0) / error(48.0)

"""Visibility maps of every size: M from the least to the most of its row."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from functools import cache, partial
from pathlib import Path

import numpy as np

import viscache as vc
from viscache.settings.maps import ROWS
from viscache_lab.experiment import FAMILIES, Case
from viscache_lab.extremes import scenes
from viscache_lab.extremes.families.tables import sky_excess
from viscache_lab.extremes.pictures import METHODS, SIZE, picture, rel_l1

MAPS = METHODS["visibility maps"]


@FAMILIES.add("map_sizes", "visibility maps of 2^M × 2^M cells, M = 4 … 7")
def map_sizes(full: bool) -> Iterator[Case]:
    row = ROWS.by_name["m"]
    for m in range(int(row["low"]), int(row["high"]) + 1):
        maps = vc.VisMaps(n_startup=400 if full else 64, m=m)
        yield Case(
            name=f"M = {m}, maps in place of rays: rel_l1 against 1024 rays per pixel",
            measure=partial(_error, maps, "replace"),
            limit=0.025,
            why="blends of maps some pixels away: measured 0.0104 … 0.0108, twice that",
        )
        yield Case(
            name=f"M = {m}, maps as control variate: energy against 1024 rays per pixel",
            measure=partial(_energy, maps),
            limit=3e-3,
            why="no bias; noise of 16 samples per pixel: measured 8e-4 at most, 4 times that",
        )
        yield Case(
            name=f"M = {m}: light above what the open sky brings",
            measure=partial(sky_excess, maps),
            limit=1e-3,
            why="a blend of maps is a share of the sky; its integral over an open sky errs by 5e-4",
        )
        yield Case(
            name=f"M = {m}, saved and loaded: pixels that differ",
            measure=partial(_reloaded, m),
            why="a file holds every bit of the records",
        )


@cache
def _scene() -> vc.Scene:
    return scenes.with_parts(scenes.floor(), scenes.table(), lights=()).with_environment(1.0)


@cache
def _exact() -> vc.Frame:
    return picture(_scene(), integrator=vc.Direct(environment="product", n_environment=1024))


def _error(maps: vc.VisMaps, use: str) -> float:
    return rel_l1(picture(_scene(), MAPS, visibility=maps, use=use, env=None), _exact())


def _energy(maps: vc.VisMaps) -> float:
    frame = picture(
        _scene(),
        integrator=vc.Direct(environment="product", n_environment=16),
        visibility=maps,
        use="correct",
    )
    return float(abs(frame.image.astype(float).sum() / _exact().image.astype(float).sum() - 1))


def _reloaded(m: int) -> float:
    scene, settings = _scene(), vc.MapSettings(n_startup=64, m=m)
    made = vc.VisibilityMapCache(scene, settings)
    made.update(size=SIZE, threads=1)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "maps"
        made.save(path)
        again = vc.VisibilityMapCache.load(path, scene)
    frames = [
        picture(scene, MAPS, visibility=vc.VisMaps(cache=kept), env=None).image
        for kept in (made, again)
    ]
    return float((np.asarray(frames[0]) != np.asarray(frames[1])).any(axis=-1).sum())

"""Part of `viscache bench vlf-build`: moving an object in a field against rebuilding the field."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from typing import Any, Literal

import numpy as np

import viscache as vc
from viscache.vlf.dynamic import DynamicField
from viscache_lab.cases.beams import chords
from viscache_lab.cases.moving_object import STOPS, ball, with_object
from viscache_lab.experiment import Trial
from viscache_lab.experiment.amounts import turns

UPDATED, QUICK_UPDATED = "bumpy_spheres?triangles=100000", "bumpy_spheres?triangles=3000"
FIELD = vc.Vlf(n_tiles=128, bsp_depth=3, head_room=1.25, max_bytes=4 << 30)
QUICK_FIELD = vc.Vlf(n_directions=33, n_tiles=64, bsp_depth=3, head_room=1.25)
#: Triangles of the object that moves.
SIZES, QUICK_SIZES = (100, 1000, 10_000), (100,)
RAYS, QUICK_RAYS = 20_000, 2000
REPEATS = 2
#: Allowed share of rays whose nearest hit differs from that of the rebuilt field.
DIFFERING = 1e-4


def compare_updates(trial: Trial, scene: vc.Scene) -> None:
    """CPU seconds of an update, in both modes, and of a field built with the object in place."""
    settings, sizes = (QUICK_FIELD, QUICK_SIZES) if trial.quick else (FIELD, SIZES)
    beams = chords(scene, QUICK_RAYS if trial.quick else RAYS)
    modes: tuple[Literal["overlay", "in_place"], ...] = ("overlay", "in_place")
    for mode in modes:
        field = DynamicField(scene, settings, mode=mode)
        for size in sizes:
            vertices, triangles = ball(size, (0.0, 0.5, 0.0))
            number = field.insert(vertices, triangles)
            moved = with_object(scene, vertices + np.array(STOPS[REPEATS - 1]), triangles)
            stops = iter(STOPS)
            runs: dict[str, Callable[[], Any]] = {
                "update": partial(_move, field, number, stops),
                "rebuild": partial(settings.build, moved),
            }
            samples, built = turns(runs, REPEATS, warm_up=False)
            label = f"field of {scene.triangles} triangles, {mode}, {len(triangles)} moved"
            trial.ratio(f"{label} vs rebuild", samples["update"], samples["rebuild"])
            found = field.intersect(beams.origins, beams.directions).t
            expected = built["rebuild"].intersect(beams.origins, beams.directions)[0]
            differ = float(np.mean(~np.isclose(found, expected, rtol=1e-5, atol=0)))
            trial.check(f"{label}: share unlike the field built anew", differ, DIFFERING)
            field.delete(number)


def _move(field: DynamicField, number: int, stops: Iterator[tuple[float, float, float]]) -> None:
    matrix = np.eye(4)
    matrix[:3, 3] = next(stops)
    field.transform(number, matrix)

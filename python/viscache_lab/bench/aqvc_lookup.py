"""`viscache bench aqvc-lookup`: the cost of a query in each form of the cache, and of a ray."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from statistics import median
from typing import Any

import numpy as np

import viscache as vc
from viscache.aqvc.equations import level_hashes
from viscache.metrics import compare
from viscache.settings.visibility import Visibility
from viscache_lab.experiment import BENCHES, Trial
from viscache_lab.experiment.amounts import Sample, turns, visibility_clock


@BENCHES.add(
    "aqvc-lookup",
    "nanoseconds per query of each form of the quantized cache, beside one ray",
    cases=("room?triangles=200000",),
    quick_cases=("room?triangles=20000",),
)
def aqvc_lookup(trial: Trial, _: str, scene: vc.Scene) -> None:
    """Time per query inside the oracle, with its misses traced and with almost no misses."""
    size, n_vpls = ((96, 96), 64) if trial.quick else ((512, 512), 256)
    settings: dict[str, Visibility] = {"ray": vc.Exact(engine="packets")}
    for name, form in {"waves": vc.PaperForm(), "pairs": vc.PaperForm(form="pairs")}.items():
        settings[name] = vc.Aqvc(c_e=10, refinement="on", paper=form)
        # The cells are so large that a look-up answers nearly every query
        settings[f"{name}, look-ups alone"] = vc.Aqvc(c_e=200, refinement="off", paper=form)
    settings |= storages()
    shot = vc.Shot(scene, vc.Whitted(n_vpls=n_vpls), size=size)
    scene.caster()
    runs = {key: shot.with_(visibility=by).render for key, by in settings.items()}
    samples, frames = turns(runs, trial.repeats(3, 2), warm_up=False, clock=visibility_clock)
    queries = {key: max(1, frame.counters["queries"]) for key, frame in frames.items()}
    for key, frame in frames.items():
        if key == "ray":
            continue
        error = compare(frame, frames["ray"]).rel_l1 or 0.0
        _nanoseconds(
            trial,
            f"{key} ns/query vs ns/ray",
            *((samples[k], queries[k]) for k in (key, "ray")),
            rel_l1=error,
            share_rays=frame.counters["rays"] / queries[key],
        )
        other = frame.counters["queries"] != frames["ray"].counters["queries"]
        trial.check(f"{key}: other queries than exact", float(other), 0)
        if "alone" not in key:
            trial.check(f"{key}: rel_l1", error, 0.1)
    keys(20_000 if trial.quick else 500_000, trial)


def _nanoseconds(
    trial: Trial,
    name: str,
    ours: tuple[list[Sample], int],
    theirs: tuple[list[Sample], int],
    **more: Any,
) -> None:
    """CPU time of each of a number of queries."""
    mine, other = ([1e9 * s.cpu_s / n for s in samples] for samples, n in (ours, theirs))
    ratios = [b / a for a, b in zip(mine, other, strict=True)]
    base = median(other)
    trial.figure(name, median(mine), "ns", baseline=base, ratios=ratios, clock="cpu", **more)


def storages() -> dict[str, Visibility]:
    """The paper's alternatives to batches: single queries, its queue, its tiles, and both."""
    tiles = vc.PaperForm(form="pairs", storage="paper_tiles")
    ways = {
        "pairs, one at a time": replace(tiles, storage="table", batch=1),
        "pairs, queue of 64": replace(tiles, storage="table", queue=64),
        "pairs, tiles of 32² and 4 MiB a thread": replace(tiles, batch=1),
        "pairs, both": replace(tiles, queue=64),
    }
    return {name: vc.Aqvc(c_e=10, refinement="on", paper=way) for name, way in ways.items()}


def keys(points: int, trial: Trial) -> None:
    """Nanoseconds per key: cells and hashes of four levels, in sequence and at once."""
    rng = np.random.default_rng(1)
    x, lights = rng.uniform(-1, 1, (2, points, 3)).astype(np.float32)
    normals = rng.normal(size=(points, 3)).astype(np.float32)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    resolutions = 400.0 * rng.uniform(0.5, 2, (points, 1)) * 2.0 ** np.arange(4)
    given = (vc.Aqvc(c_z=8.0), (0.0, 0.0, 0.0), 2.0, x, normals, resolutions, lights)
    samples, found = turns(
        {n: partial(level_hashes, *given, at_once=n == "four") for n in ("four", "one")},
        5,
        clock=lambda answer: Sample(wall_s=answer[-1], cpu_s=answer[-1]),
    )
    both = zip(found["one"][:-1], found["four"][:-1], strict=True)
    same = all(np.array_equal(a, b) for a, b in both)
    trial.check("keys of 4 levels at once: other hashes", float(not same), 0)
    name = "ns/key of 4 levels at once vs one at a time"
    _nanoseconds(trial, name, *((samples[n], 4 * points) for n in ("four", "one")), rel_l1=0.0)

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
from viscache_lab.experiment.amounts import Sample, build_scene, figure, turns


@BENCHES.add(
    "aqvc-lookup", "nanoseconds per query of each form of the quantized cache, beside one ray"
)
def aqvc_lookup(trial: Trial) -> None:
    """Time per query inside the oracle, with its misses traced and with almost no misses."""
    scene = build_scene("room?triangles=20000" if trial.quick else "room?triangles=200000")
    size = (96, 96) if trial.quick else (512, 512)
    integrator = vc.Whitted(n_vpls=64 if trial.quick else 256)
    settings: dict[str, Visibility] = {"ray": vc.Exact(engine="packets")}
    forms = {"waves": vc.PaperForm(), "pairs": vc.PaperForm(form="pairs")}
    for name, form in forms.items():
        settings[name] = vc.Aqvc(c_e=10, refinement="on", paper=form)
        # The cells are so large that a look-up answers nearly every query
        settings[f"{name}, look-ups alone"] = vc.Aqvc(c_e=200, refinement="off", paper=form)
    settings |= storages()
    shot = vc.Shot(scene, integrator, size=size)
    scene.caster()
    asked = turns(
        {key: shot.with_(visibility=by).render for key, by in settings.items()},
        2 if trial.quick else 3,
        warm_up=False,
        clock=of_visibility,
    )
    samples, frames = asked.samples, asked.answers
    exact = frames["ray"]
    per_query = {
        key: [s.cpu_s / max(1, frames[key].counters["queries"]) * 1e9 for s in samples[key]]
        for key in settings
    }
    for key in settings:
        if key == "ray":
            continue
        ratios = [a / b for a, b in zip(per_query["ray"], per_query[key], strict=True)]
        error = compare(frames[key], exact).rel_l1 or 0.0
        trial.figure(
            f"{key} ns/query vs ns/ray",
            sorted(per_query[key])[len(ratios) // 2],
            "ns",
            baseline=sorted(per_query["ray"])[len(ratios) // 2],
            ratios=ratios,
            rel_l1=error,
            share_rays=frames[key].counters["rays"] / max(1, frames[key].counters["queries"]),
            clock="cpu",
        )
        same = frames[key].counters["queries"] == exact.counters["queries"]
        trial.check(f"{key}: other queries than exact", float(not same), 0)
        if "alone" not in key:
            trial.check(f"{key}: rel_l1", error, 0.1)
    trial.figures.append(keys(20_000 if trial.quick else 500_000, trial))


def of_visibility(frame: vc.Frame) -> Sample:
    """The time of a frame's oracle."""
    t = frame.timings
    return Sample(wall_s=t["visibility_s"], cpu_s=t["visibility_cpu_s"])


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


def keys(points: int, trial: Trial) -> dict[str, Any]:
    """Nanoseconds per key: cells and hashes of four levels, in sequence and at once."""
    rng = np.random.default_rng(1)
    x, lights = rng.uniform(-1, 1, (2, points, 3)).astype(np.float32)
    normals = rng.normal(size=(points, 3)).astype(np.float32)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    resolutions = 400.0 * rng.uniform(0.5, 2, (points, 1)) * 2.0 ** np.arange(4)
    parameters = vc.Aqvc(c_z=8.0)
    given = (parameters, (0.0, 0.0, 0.0), 2.0, x, normals, resolutions, lights)
    asked = turns(
        {n: partial(level_hashes, *given, at_once=n == "four") for n in ("one", "four")},
        5,
        clock=lambda answer: Sample(wall_s=answer[-1], cpu_s=answer[-1]),
    )
    samples, found = asked.samples, {n: answer[:-1] for n, answer in asked.answers.items()}
    per_key = {n: [s.cpu_s / (4 * points) * 1e9 for s in made] for n, made in samples.items()}
    ratios = [a / b for a, b in zip(per_key["one"], per_key["four"], strict=True)]
    same = all(np.array_equal(a, b) for a, b in zip(found["one"], found["four"], strict=True))
    trial.check("keys of 4 levels at once: other hashes", float(not same), 0)
    return figure(
        "ns/key of 4 levels at once vs one at a time",
        median(per_key["four"]),
        "ns",
        baseline=median(per_key["one"]),
        ratios=ratios,
        rel_l1=0.0,
        clock="cpu",
    )

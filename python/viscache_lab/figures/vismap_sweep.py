"""Variance, rays, bytes and time over the visibility cache's parameters (not in the paper)."""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import viscache as vc
from viscache.base.progress import step_bar
from viscache.metrics.variance import VarianceRatio
from viscache.plots import COLORS, pareto
from viscache.scenes import build
from viscache_lab.cases.map_renders import variance_left
from viscache_lab.cases.simulation import Way, simulate
from viscache_lab.experiment import FIGURES, Row, Trial
from viscache_lab.experiment.drawing import Panel, Series
from viscache_lab.figures.bands import vismap as bands

SCENE, QUICK_SCENE = "garage", "garage?triangles=60000"
SIZE, QUICK_SIZE = (640, 480), (160, 120)
FULL: dict[str, Any] = {"n_pixels": 256, "replicates": 32}
QUICK: dict[str, Any] = {"n_pixels": 24, "replicates": 16}
SAMPLES = 30
PRODUCT = Way()
VARIATE = Way(alpha="previous_pass", passes=6)
GUIDED = Way(alpha="previous_pass", passes=6, eta=0.25)

#: One parameter at a time around the preset "medium"; both thresholds change together, by preset.
GRID: dict[str, tuple[dict[str, Any], ...]] = {
    "m": tuple({"m": m} for m in (4, 5, 6, 7)),
    "n_best": tuple({"n_best": n} for n in (1, 2, 4, 8)),
    "theta_max_deg": tuple({"theta_max_deg": t} for t in (10.0, 20.0, 30.0, 45.0)),
    "w_min": tuple({"w_min": w} for w in (0.1, 0.2, 0.3, 0.4, 0.6)),
    "delta_max": tuple({"delta_max": d} for d in (0.2, 0.1, 0.06, 0.04, 0.02)),
    "both thresholds": tuple(
        {"w_min": w, "delta_max": d} for w, d in ((0.1, 0.2), (0.3, 0.06), (0.6, 0.02))
    ),
}


@dataclass(frozen=True, kw_only=True, slots=True)
class Setting:
    """Costs and remaining variance of one setting."""

    records: int
    rays_per_pixel: float
    nbytes: int
    seconds: float
    variate: VarianceRatio
    guided: VarianceRatio


@FIGURES.add("vismap-sweep", "variance, rays and bytes over the cache's parameters")
def sweep(trial: Trial) -> None:
    """The grid in the garage, and the settings that are Pareto-optimal in rays and variance."""
    scene = build(QUICK_SCENE if trial.quick else SCENE)
    found: dict[str, dict[str, Setting]] = {}
    total = sum(len(values) for values in GRID.values())
    with step_bar(trial.progress, total, unit="setting") as step:
        for name, values in GRID.items():
            found[name] = {}
            for value in values:
                found[name][_label(value)] = measure(scene, value, trial.quick)
                step()
    trial.rows += _rows(found)
    trial.draw("vismap-sweep.png", [_panels(found)], (11.0, 4.4), dpi=150)
    trial.notes.append(
        f"variance left at {SAMPLES} samples, rqmc, alpha of earlier passes, in the world of the "
        "environment's texels"
    )


def measure(scene: vc.Scene, value: Mapping[str, Any], quick: bool) -> Setting:
    """Build a cache, and estimate random pixels with it."""
    size = QUICK_SIZE if quick else SIZE
    cache = vc.VisibilityMapCache(scene, vc.MapSettings(**value))
    start = time.perf_counter()
    report = cache.update(size=size)
    seconds = time.perf_counter() - start
    made = simulate(
        cache, [PRODUCT, VARIATE, GUIDED], [SAMPLES], size=size, **(QUICK if quick else FULL)
    )

    return Setting(
        records=len(cache),
        rays_per_pixel=report.rays / (size[0] * size[1]),
        nbytes=cache.nbytes,
        seconds=seconds,
        variate=variance_left(made, VARIATE, PRODUCT, SAMPLES),
        guided=variance_left(made, GUIDED, PRODUCT, SAMPLES),
    )


def _label(value: Mapping[str, Any]) -> str:
    return ", ".join(f"{name} {number:g}" for name, number in value.items())


def _rows(found: Mapping[str, Mapping[str, Setting]]) -> Iterator[Row]:
    for settings in found.values():
        for label, s in settings.items():
            note = (
                f"{s.records} records, {s.rays_per_pixel:.3g} rays per pixel, "
                f"{s.nbytes / 1e6:.3g} MB, {s.seconds:.2g} s; guided "
                f"{s.guided.ratio:.3f} ({s.guided.low:.3f} to {s.guided.high:.3f})"
            )
            yield Row(f"{label}: variance left", s.variate.ratio, note=note)
    maps = list(found["m"].values())
    ends = list(found["both thresholds"].values())
    yield Row(
        "variance left with 64x64 cells over that with 32x32",
        maps[2].variate.ratio / maps[1].variate.ratio,
        band=bands.LARGER_MAPS,
    )
    yield Row(
        "variance left with the tightest thresholds over that with the loosest",
        ends[-1].variate.ratio / ends[0].variate.ratio,
        band=bands.MORE_RECORDS_HELP,
    )


def _panels(found: Mapping[str, Mapping[str, Setting]]) -> list[Panel]:
    panels = []
    titles = {"variate": "control variate", "guided": "control variate, guided sampling"}
    for kind, title in titles.items():
        points = {
            name: [(s.rays_per_pixel, getattr(s, kind).ratio) for s in settings.values()]
            for name, settings in found.items()
        }
        series = [
            Series.through(name, some, "o-", COLORS[k % len(COLORS)])
            for k, (name, some) in enumerate(points.items())
        ]
        best = pareto([point for some in points.values() for point in some])
        series.append(Series.through("not beaten", best, "k--"))
        panels.append(
            Panel(
                series=series,
                title=title,
                x="rays for records, per pixel",
                y="variance left",
                logarithmic="x",
                legend=kind == "guided",
                more=lambda axes: axes.set_ylim(bottom=0),
            )
        )
    return panels

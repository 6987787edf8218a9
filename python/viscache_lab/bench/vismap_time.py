"""Variance in equal time, from rendered pictures: a part of `viscache bench vismap-variance`.

Times are CPU seconds of all threads and include new records for every picture, so pictures must be
large enough to share records.
"""

from __future__ import annotations

import statistics
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import viscache as vc
from viscache.metrics.variance import variance_ratio
from viscache_lab.cases.map_renders import Picture, cpu_median, images, paper_maps, samples_in
from viscache_lab.experiment import Trial
from viscache_lab.experiment.amounts import build_scene

SAMPLES = 30
GUIDED = vc.VisMaps(sampling="guided")
#: The rival without maps: shared directions in sets, as in `viscache bench peers`.
DEALT, SETS = 512, 16
#: Limit of look-ups, J and records together, in µs per pixel and core.
MOST_US = 5.0
#: Limit of the time to build the cache of 128×96 pixels.
MOST_BUILD_S = 1.0


@dataclass(frozen=True, slots=True)
class Case:
    """A picture and the required gain in equal time."""

    scene: str
    quick_scene: str
    size: tuple[int, int]
    renders: int
    goals: dict[str, float]


CASES = (
    Case("garage", "garage?triangles=30000", (640, 480), 3, {"control variate, alpha 1": 2.0}),
    Case("window_room", "window_room", (128, 96), 12, {"guided": 6.0}),
)
QUICK_SIZE = (24, 18)


def equal_time(trial: Trial) -> None:
    """Gains in equal time, the cost of look-ups, the time to build a cache."""
    for full in CASES:
        # Small pictures have too few pixels to share records, so they have no goals
        quick = replace(full, scene=full.quick_scene, size=QUICK_SIZE, goals={}, renders=2)
        case = quick if trial.quick else full
        picture = Picture(scene=build_scene(case.scene), size=case.size)
        gain = partial(_gain, trial, full.scene, case, picture)
        for name, maps in {"control variate, alpha 1": paper_maps(None), "guided": GUIDED}.items():
            frames = [picture.maps(SAMPLES, maps) for _ in range(3)]
            kept = replace(maps, cache=picture.build_cache(), update=False)
            gain(name, frames, partial(picture.maps, SAMPLES, kept))
        _costs(trial, full.scene, picture, frames)
        frames = [picture.dealt(DEALT, SETS) for _ in range(3)]
        rival = f"{DEALT} shared directions in {SETS} sets"
        gain(rival, frames, partial(picture.dealt, DEALT, SETS))
    trial.notes.append("equal time is that of all processors, records made anew each time")


def _gain(
    trial: Trial,
    scene: str,
    case: Case,
    picture: Picture,
    name: str,
    frames: list[vc.Frame],
    make: Callable[[int], vc.Frame],
) -> None:
    """The variance of `make(seed)` beside product sampling in the time of `frames`."""
    equal = samples_in(picture, cpu_median(frames))
    left = variance_ratio(
        images(make, range(case.renders)),
        images(lambda seed: picture.product(equal, seed), range(100, 100 + case.renders)),
    )
    trial.figure(
        f"{scene}, {name}, equal time vs product sampling",
        left.ratio,
        "of the variance",
        baseline=1.0,
        ratios=left.gains,
        goal=case.goals.get(name),
        samples_of_baseline=equal,
        energy_z=left.energy_z,
    )


def _costs(trial: Trial, scene: str, picture: Picture, frames: list[vc.Frame]) -> None:
    """Of guided frames, whose records are made anew."""
    pixels = picture.size[0] * picture.size[1]

    def us(stage: str) -> float:
        return statistics.median(f.timings[stage] for f in frames) / pixels * 1e6

    kept = replace(GUIDED, cache=picture.build_cache(), update=False)
    with_records = [picture.maps(SAMPLES, kept) for _ in range(3)]
    records = cpu_median(frames) - cpu_median(with_records)
    maps_us = us("maps_cpu_s") + max(records, 0.0) / pixels * 1e6
    trial.figure(
        f"{scene}, look-ups, J and records vs {MOST_US:g} us per pixel",
        maps_us,
        "us per pixel",
        baseline=MOST_US,
        ratios=[MOST_US / maps_us],
        goal=None if trial.quick else 1.0,
        trees_us=us("trees_cpu_s"),
        sample_us=us("samples_cpu_s") / SAMPLES,
    )
    built = statistics.median(frame.timings["records_s"] for frame in frames)
    trial.figure(
        f"{scene}, records of {picture.size[0]}x{picture.size[1]} pixels vs 1 s",
        built,
        "s",
        baseline=MOST_BUILD_S,
        ratios=[MOST_BUILD_S / max(built, 1e-9)],
        goal=1.0 if picture.size == (128, 96) else None,
    )

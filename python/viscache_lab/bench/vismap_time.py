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
from viscache_lab.cases.map_renders import Picture, images, paper_maps, samples_in
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


@dataclass(frozen=True, kw_only=True, slots=True)
class Case:
    """A picture and the required gain in equal time."""

    scene: str
    quick_scene: str
    size: tuple[int, int]
    renders: int
    goals: dict[str, float]


CASES = (
    Case(
        scene="garage",
        quick_scene="garage?triangles=30000",
        size=(640, 480),
        renders=3,
        goals={"control variate, alpha 1": 2.0},
    ),
    Case(
        scene="window_room",
        quick_scene="window_room",
        size=(128, 96),
        renders=12,
        goals={"guided": 6.0},
    ),
)
QUICK_SIZE, QUICK_RENDERS = (24, 18), 2


def equal_time(trial: Trial, quick: bool) -> None:
    """Gains in equal time, the cost of look-ups, the time to build a cache."""
    for full in CASES:
        # Small pictures have too few pixels to share records, so they have no goals
        case = replace(full, goals={}, renders=QUICK_RENDERS) if quick else full
        picture = Picture(
            scene=build_scene(case.quick_scene if quick else case.scene),
            size=QUICK_SIZE if quick else case.size,
        )
        ways = {"control variate, alpha 1": paper_maps(None), "guided": GUIDED}
        for name, maps in ways.items():
            frames = [picture.maps(SAMPLES, maps) for _ in range(3)]
            kept = replace(maps, cache=picture.build_cache(), update=False)
            _gain(trial, case, picture, name, frames, partial(picture.maps, SAMPLES, kept))
            if name == "guided":
                _costs(trial, case, picture, frames)
        frames = [picture.dealt(DEALT, SETS) for _ in range(3)]
        rival = f"{DEALT} shared directions in {SETS} sets"
        _gain(trial, case, picture, rival, frames, partial(picture.dealt, DEALT, SETS))
    trial.notes.append("equal time is that of all processors, records made anew each time")


def _gain(
    trial: Trial,
    case: Case,
    picture: Picture,
    name: str,
    frames: list[vc.Frame],
    make: Callable[[int], vc.Frame],
) -> None:
    """The variance of `make(seed)` beside product sampling in the time of `frames`."""
    equal = samples_in(picture, statistics.median(frame.timings["cpu_s"] for frame in frames))
    left = variance_ratio(
        images(make, range(case.renders)),
        images(lambda seed: picture.product(equal, seed), range(100, 100 + case.renders)),
    )
    trial.figure(
        f"{case.scene}, {name}, equal time vs product sampling",
        left.ratio,
        "of the variance",
        baseline=1.0,
        ratios=left.gains,
        goal=case.goals.get(name),
        samples_of_baseline=equal,
        energy_z=left.energy_z,
    )


def _costs(trial: Trial, case: Case, picture: Picture, frames: list[vc.Frame]) -> None:
    pixels = picture.size[0] * picture.size[1]

    def us(*stages: str) -> float:
        return statistics.median(
            sum(f.timings[stage] for stage in stages) / pixels * 1e6 for f in frames
        )

    records = statistics.median(f.timings["cpu_s"] for f in frames) - statistics.median(
        f.timings["cpu_s"]
        for f in (
            picture.maps(SAMPLES, replace(GUIDED, cache=picture.build_cache(), update=False))
            for _ in range(3)
        )
    )
    quick = not case.goals
    maps_us = us("maps_cpu_s") + max(records, 0.0) / pixels * 1e6
    trial.figure(
        f"{case.scene}, look-ups, J and records vs {MOST_US:g} us per pixel",
        maps_us,
        "us per pixel",
        baseline=MOST_US,
        ratios=[MOST_US / maps_us],
        goal=None if quick else 1.0,
        trees_us=us("trees_cpu_s"),
        sample_us=us("samples_cpu_s") / SAMPLES,
    )
    built = statistics.median(frame.timings["records_s"] for frame in frames)
    small = picture.size == (128, 96)
    trial.figure(
        f"{case.scene}, records of {picture.size[0]}x{picture.size[1]} pixels vs 1 s",
        built,
        "s",
        baseline=MOST_BUILD_S,
        ratios=[MOST_BUILD_S / max(built, 1e-9)],
        goal=1.0 if small else None,
    )

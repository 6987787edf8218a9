"""`viscache bench vismap-variance`: variance with visibility maps against product sampling.

Random pixels are estimated many times as in `viscache_lab.cases.simulation`, on both sides with as
many samples from the same kind of points. In the *steady state*, α comes from earlier passes. Then
rendered pictures in equal time: CPU seconds of all threads, new records for every picture.
"""

from __future__ import annotations

import statistics
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

import viscache as vc
from viscache.metrics.variance import variance_ratio
from viscache_lab.cases.map_renders import Picture, cpu_median, images, paper_maps, samples_in
from viscache_lab.cases.simulation import PixelEstimates, Way, simulate
from viscache_lab.experiment import BENCHES, Trial
from viscache_lab.experiment.amounts import build_scene

AT = 30
GUIDED = vc.VisMaps(sampling="guided")
#: The rival without maps: shared directions in sets, as in `viscache bench peers`.
DEALT, SETS = 512, 16
#: Limit of look-ups, J and records together, in µs per pixel and core.
MOST_US = 5.0
#: Limit of the time to build the cache of 128×96 pixels.
MOST_BUILD_S = 1.0


@dataclass(frozen=True, slots=True)
class Timed:
    """A picture and the required gain in equal time."""

    scene: str
    quick_scene: str
    size: tuple[int, int]
    renders: int
    goals: dict[str, float]


TIMED = (
    Timed("garage", "garage?triangles=30000", (640, 480), 3, {"control variate, alpha 1": 2.0}),
    Timed("window_room", "window_room", (128, 96), 12, {"guided": 6.0}),
)
TINY = (24, 18)


def equal_time(trial: Trial) -> None:
    """Gains in equal time, the cost of look-ups, the time to build a cache."""
    for full in TIMED:
        # Small pictures have too few pixels to share records, so they have no goals
        quick = replace(full, scene=full.quick_scene, size=TINY, goals={}, renders=2)
        case = quick if trial.quick else full
        picture = Picture(scene=build_scene(case.scene), size=case.size)
        gain = partial(_gain, trial, full.scene, case, picture)
        for name, maps in {"control variate, alpha 1": paper_maps(None), "guided": GUIDED}.items():
            frames = [picture.maps(AT, maps) for _ in range(3)]
            kept = replace(maps, cache=picture.build_cache(), update=False)
            gain(name, frames, partial(picture.maps, AT, kept))
        _costs(trial, full.scene, picture, frames)
        frames = [picture.dealt(DEALT, SETS) for _ in range(3)]
        rival = f"{DEALT} shared directions in {SETS} sets"
        gain(rival, frames, partial(picture.dealt, DEALT, SETS))
    trial.notes.append("equal time is that of all processors, records made anew each time")


def _gain(
    trial: Trial,
    scene: str,
    case: Timed,
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
    with_records = [picture.maps(AT, kept) for _ in range(3)]
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
        sample_us=us("samples_cpu_s") / AT,
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


ETA = 0.25
#: Passes of a pixel in the steady state: the first five give α for the last.
STEADY = 6
#: Probability that a bench without bias fails.
FALSE_ALARM = 1e-3

WAYS: dict[str, Way] = {
    "control variate, alpha 1": Way(alpha=1.0),
    "control variate, alpha of earlier passes": Way(alpha="previous_pass", passes=STEADY),
    "guided": Way(alpha="previous_pass", eta=ETA, passes=STEADY),
    "one pass, alpha of a pilot": Way(alpha="previous_pass", first="pilot"),
    "one shot, first alpha of a pilot": Way(alpha="previous_pass", one_shot=True, first="pilot"),
    "one shot, first alpha 1": Way(alpha="previous_pass", one_shot=True),
    "one shot, guided": Way(alpha="previous_pass", eta=ETA, one_shot=True, first="pilot"),
}
#: All samples in one pass, hence also one shot.
IID_ONLY = {"control variate, leave-one-out": Way(alpha="loo", points="iid")}


@dataclass(frozen=True, slots=True)
class Case:
    """A picture, and the largest remaining share of the variance for some of the ways."""

    name: str
    scene: str
    quick_scene: str
    goals: Mapping[tuple[str, str, int], float]  # by way, points and samples
    camera: int = 0
    m: int = 5  # a map has 2^m × 2^m cells


STEADY_WAY, PAPER = "control variate, alpha of earlier passes", "control variate, alpha 1"
GARDEN_GOALS = {
    **{(STEADY_WAY, points, n): 1.03 for points in ("iid", "rqmc") for n in (10, 30, 100)},
    **{("control variate, leave-one-out", "iid", n): 1.03 for n in (30, 100)},
}
GARAGE_GOALS = {("guided", "rqmc", 10): 0.27, ("guided", "rqmc", 30): 0.2}
CASES = (
    Case("garage", "garage", "garage?triangles=60000", GARAGE_GOALS | {(PAPER, "rqmc", 10): 0.45}),
    Case("garage, maps of 64x64", "garage", "garage?triangles=60000", GARAGE_GOALS, m=6),
    Case("garden1", "garden", "garden?triangles=60000", GARDEN_GOALS),
    Case("garden2", "garden", "garden?triangles=60000", GARDEN_GOALS, camera=1),
    Case("window_room", "window_room", "window_room", {("guided", "rqmc", 30): 1 / 20}),
)
SAMPLES, QUICK_SAMPLES = (10, 30, 100), (10, 30)
FULL, QUICK = {"n_pixels": 512, "replicates": 64}, {"n_pixels": 24, "replicates": 16}
SIZE, QUICK_SIZE = (640, 480), (160, 120)


@BENCHES.add(
    "vismap-variance",
    "variance with visibility maps against product sampling",
    note="values are variances left; ratios are gains, product sampling over ours, with the 95 % "
    "interval of a bootstrap over replicates; in the world of the environment's texels",
)
def vismap_variance(trial: Trial) -> None:
    """Run every case, way and point set."""
    size = QUICK_SIZE if trial.quick else SIZE
    for case in CASES:
        scene = build_scene(case.quick_scene if trial.quick else case.scene)
        cache = vc.VisibilityMapCache(scene, vc.MapSettings(m=case.m))
        cache.update(case.camera, size=size)
        samples = QUICK_SAMPLES if trial.quick else SAMPLES
        found = simulate(
            cache,
            all_ways(),
            samples,
            camera=case.camera,
            size=size,
            **(QUICK if trial.quick else FULL),
        )
        add_figures(trial, case, found, samples, len(cache))
        check_means(trial, case.name, found)
    equal_time(trial)


def all_ways() -> list[Way]:
    """The baseline and every way, each with both kinds of points."""
    return [way for pair in _pairs().values() for way in pair]


def _pairs() -> dict[tuple[str, str], tuple[Way, Way]]:
    """By name and points: product sampling, and the way."""
    sets: tuple[tuple[str, Mapping[str, Way]], ...] = (
        ("iid", {**WAYS, **IID_ONLY}),
        ("rqmc", WAYS),
    )
    return {
        (name, points): (Way(points=points), replace(way, points=points))  # type: ignore[arg-type]
        for points, ways in sets
        for name, way in ways.items()
    }


def add_figures(
    trial: Trial, case: Case, found: PixelEstimates, samples: Sequence[int], n_records: int
) -> None:
    """A figure of every way, point set and number of samples."""
    for (name, points), (baseline, way) in _pairs().items():
        for n in samples:
            # Replicates (K, P) as renders of one row
            left = variance_ratio(
                *(list(found.estimates[w, n][:, None, :, None]) for w in (way, baseline))
            )
            limit = case.goals.get((name, points, n))
            trial.figure(
                f"{case.name}, {name}, {points}, {n} samples vs product sampling",
                left.ratio,
                "of the variance",
                baseline=1.0,
                ratios=left.gains,
                goal=None if limit is None else 1 / limit,
                records=n_records,
                trimmed=left.trimmed,
                worse_share=left.worse_share,
            )


def check_means(trial: Trial, name: str, found: PixelEstimates) -> None:
    """Check for each way that sums over pixels agree with the true values within chance."""
    from scipy.stats import t  # type: ignore[import-untyped,unused-ignore]

    worst, n_replicates = 0.0, 2
    for estimates in found.estimates.values():
        error = (estimates - found.truth).sum(axis=1)
        n_replicates = len(error)
        spread = error.std(ddof=1) / np.sqrt(n_replicates)
        worst = max(worst, abs(float(error.mean())) / max(float(spread), 1e-300))
    single = 1 - (1 - FALSE_ALARM) ** (1 / (len(found.estimates) * len(CASES)))
    limit = float(t.ppf(1 - single / 2, n_replicates - 1))
    trial.check(f"{name}: largest |z| of {len(found.estimates)} means", worst, limit)

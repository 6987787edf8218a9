"""`viscache bench threads`: wall-clock time with 1, 2, 4, … threads, and the same bytes."""

from __future__ import annotations

import os
import statistics
from dataclasses import dataclass, field
from functools import cache, partial
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

import viscache as vc
from viscache.settings.integrators import Integrator
from viscache.settings.visibility import Visibility
from viscache_lab.experiment import BENCHES, Trial
from viscache_lab.experiment.amounts import turns

#: Least speed-up with two threads.
GOAL_OF_TWO = 1.9
ROOM = "room?triangles=200000"
SEGMENTS = 4_000_000
FIELD = vc.Vlf(n_directions=129, n_tiles=64)


class Work(Protocol):
    """What a case times, e.g. a frame."""

    def __call__(self, scene: vc.Scene, threads: int) -> npt.NDArray[Any]:
        """The answers, whose bytes must not depend on `threads`."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Picture:
    """A frame."""

    integrator: Integrator
    visibility: Visibility = field(default_factory=lambda: vc.Exact(engine="packets"))
    size: tuple[int, int] = (512, 512)
    spp: int = 1

    def __call__(self, scene: vc.Scene, threads: int) -> npt.NDArray[Any]:
        return vc.render(
            scene,
            self.integrator,
            visibility=self.visibility,
            size=self.size,
            spp=self.spp,
            threads=threads,
        ).image


@dataclass(frozen=True, kw_only=True, slots=True)
class Passes:
    """Two corrected passes of one sample."""

    size: tuple[int, int] = (512, 512)

    def __call__(self, scene: vc.Scene, threads: int) -> npt.NDArray[Any]:
        picture = vc.Progressive(scene, vc.Whitted(n_vpls=256), size=self.size, threads=threads)
        return picture.passes(2).image


@cache
def random_ends(scene: vc.Scene) -> npt.NDArray[np.float32]:
    """Both ends of segments in the scene's box; the turn that warms up makes them."""
    ends = np.random.default_rng(0).random((2, SEGMENTS, 3), dtype=np.float32)
    low, high = scene.bounds
    return np.asarray(ends * (high - low) + low, np.float32)


def segments(scene: vc.Scene, threads: int) -> npt.NDArray[Any]:
    """Visibility of pairs of random points."""
    x, y = random_ends(scene)
    return scene.visible(x, y, threads=threads)


def built_field(scene: vc.Scene, threads: int) -> npt.NDArray[Any]:
    """Answers of a visibility field to some rays, its build included."""
    made = FIELD.build(scene, threads=threads)
    rays = np.random.default_rng(0).normal(size=(2, 1000, 3)).astype(np.float32)
    return np.asarray(made.occluded(rays[0], rays[1], np.inf, threads))


@dataclass(frozen=True, kw_only=True, slots=True)
class Case:
    """Work in a scene."""

    name: str
    work: Work
    scene: str = ROOM


LIGHTS, AQVC = vc.Whitted(n_vpls=256), vc.Aqvc(c_e=10)
SETS = vc.Direct(n_area=0, environment="shared", n_environment=512, interleave=16)
OWN = vc.Direct(n_area=0, n_environment=4, n_brdf=4)
CASES = (
    Case(name="packets, 192x192", work=Picture(integrator=LIGHTS, size=(192, 192))),
    Case(name="packets, 512x512", work=Picture(integrator=LIGHTS)),
    Case(
        name="shafts, 512x512",
        work=Picture(integrator=LIGHTS, visibility=vc.Exact(engine="shafts")),
    ),
    Case(
        name="quantized cache, 192x192",
        work=Picture(integrator=LIGHTS, visibility=AQVC, size=(192, 192)),
    ),
    Case(name="quantized cache, 512x512", work=Picture(integrator=LIGHTS, visibility=AQVC)),
    Case(
        name="quantized cache, 256x256, 16 samples",
        work=Picture(integrator=LIGHTS, visibility=vc.Aqvc(c_e=24), size=(256, 256), spp=16),
    ),
    Case(name="2 corrected passes, 512x512", work=Passes()),
    Case(
        name="ambient occlusion, 16 rays of each pixel's own",
        work=Picture(integrator=vc.AmbientOcclusion(n_samples=16)),
    ),
    Case(
        name="ambient occlusion, 513 shared directions",
        scene="bumpy_spheres?triangles=15000",
        work=Picture(integrator=vc.AmbientOcclusion(n_samples=513, directions="shared")),
    ),
    Case(name="sky, 4 + 4 own samples", scene="stairs", work=Picture(integrator=OWN, spp=4)),
    Case(
        name="sky, 512 directions in 16 sets, 256x256, 16 samples",
        scene="stairs",
        work=Picture(integrator=SETS, size=(256, 256), spp=16),
    ),
    Case(
        name="sky, visibility maps, 320x240",
        scene="garage",
        work=Picture(
            integrator=vc.Direct(environment="product"), visibility=vc.VisMaps(), size=(320, 240)
        ),
    ),
    Case(
        name="bidirectional paths, quantized cache, 256x256, 4 samples",
        scene="cornell_box",
        work=Picture(integrator=vc.Bdpt(), visibility=vc.Aqvc(), size=(256, 256), spp=4),
    ),
    Case(name="4 million random segments", work=segments),
    Case(name="a visibility field", scene="bumpy_spheres?triangles=15000", work=built_field),
)
SMALL = Picture(integrator=vc.Whitted(n_vpls=16), visibility=AQVC, size=(80, 50))
QUICK = (
    Case(name="quantized cache, 80x50", scene="room?triangles=3000", work=SMALL),
    Case(name="2 corrected passes, 80x50", scene="room?triangles=3000", work=Passes(size=(80, 50))),
)


@BENCHES.add(
    "threads",
    "wall-clock time with one thread, two, … and all cores; the bytes are the same",
    cases=CASES,
    quick_cases=QUICK,
    note="Ratios: wall-clock time with one thread over that with more, in turns.",
)
def threads(trial: Trial, case: Case, scene: vc.Scene) -> None:
    """Each case with 1, 2, 4, … and all cores, in turns."""
    cores = len(os.sched_getaffinity(0))
    counts = sorted({1 << k for k in range(cores.bit_length())} | {cores})
    if counts == [1]:
        trial.skip(f"{case.name}: speed-ups", "this process may use one core only")
    samples, answers = turns({n: partial(case.work, scene, n) for n in counts}, trial.repeats(3))
    one = samples[1]
    for n in counts[1:]:
        mine = samples[n]
        pairs = list(zip(one, mine, strict=True))
        trial.figure(
            f"{case.name}: {n} threads vs one",
            statistics.median(s.wall_s for s in mine),
            "s",
            baseline=statistics.median(s.wall_s for s in one),
            ratios=[a.wall_s / b.wall_s for a, b in pairs],
            goal=GOAL_OF_TWO if n == 2 else None,
            clock="wall",
            cpu_time_over_one=statistics.median(b.cpu_s / a.cpu_s for a, b in pairs),
        )
    trial.check(
        f"{case.name}: numbers of threads whose answers differ from those of one",
        sum(found.tobytes() != answers[1].tobytes() for found in answers.values()),
        0,
    )

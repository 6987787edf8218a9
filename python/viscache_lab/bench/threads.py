"""`viscache bench threads`: wall-clock time with 1, 2, 4, … threads, and the same bytes."""

from __future__ import annotations

import os
import statistics
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, partial
from typing import Any, TypeAlias

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
LIGHTS: Integrator = vc.Whitted(n_vpls=256)
PACKETS: Visibility = vc.Exact(engine="packets")
FIELD = vc.Vlf(n_directions=129, n_tiles=64)


#: What a case times, e.g. a frame; the bytes of its answers must not depend on threads.
Work: TypeAlias = Callable[[vc.Scene, int], npt.NDArray[Any]]


@dataclass(frozen=True, slots=True)
class Picture:
    """A frame."""

    integrator: Integrator = LIGHTS
    visibility: Visibility = PACKETS
    size: tuple[int, int] = (512, 512)
    spp: int = 1

    def __call__(self, scene: vc.Scene, threads: int) -> npt.NDArray[Any]:
        shot = vc.Shot(scene, self.integrator, size=self.size, spp=self.spp, threads=threads)
        return shot.render(visibility=self.visibility).image


def passes(scene: vc.Scene, threads: int, size: tuple[int, int] = (512, 512)) -> npt.NDArray[Any]:
    """Two corrected passes of one sample."""
    return vc.Progressive(scene, LIGHTS, size=size, threads=threads).passes(2).image


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


@dataclass(frozen=True, slots=True)
class Case:
    """Work in a scene."""

    name: str
    work: Work
    scene: str = ROOM


AQVC, SPHERES = vc.Aqvc(c_e=10), "bumpy_spheres?triangles=15000"
AMBIENT = vc.AmbientOcclusion(n_samples=16)
SHARED = vc.AmbientOcclusion(n_samples=513, directions="shared")
SETS = vc.Direct(n_area=0, environment="shared", n_environment=512, interleave=16)
OWN = vc.Direct(n_area=0, n_environment=4, n_brdf=4)
PRODUCT = vc.Direct(environment="product")
CASES = (
    Case("packets, 192x192", Picture(size=(192, 192))),
    Case("packets, 512x512", Picture()),
    Case("shafts, 512x512", Picture(visibility=vc.Exact(engine="shafts"))),
    Case("quantized cache, 192x192", Picture(visibility=AQVC, size=(192, 192))),
    Case("quantized cache, 512x512", Picture(visibility=AQVC)),
    Case(
        "quantized cache, 256x256, 16 samples",
        Picture(visibility=vc.Aqvc(c_e=24), size=(256, 256), spp=16),
    ),
    Case("2 corrected passes, 512x512", passes),
    Case("ambient occlusion, 16 rays of each pixel's own", Picture(AMBIENT)),
    Case("ambient occlusion, 513 shared directions", Picture(SHARED), SPHERES),
    Case("sky, 4 + 4 own samples", Picture(OWN, spp=4), "stairs"),
    Case(
        "sky, 512 directions in 16 sets, 256x256, 16 samples",
        Picture(SETS, size=(256, 256), spp=16),
        "stairs",
    ),
    Case(
        "sky, visibility maps, 320x240",
        Picture(PRODUCT, visibility=vc.VisMaps(), size=(320, 240)),
        "garage",
    ),
    Case(
        "bidirectional paths, quantized cache, 256x256, 4 samples",
        Picture(vc.Bdpt(), visibility=vc.Aqvc(), size=(256, 256), spp=4),
        "cornell_box",
    ),
    Case("4 million random segments", segments),
    Case("a visibility field", built_field, SPHERES),
)
SMALL_ROOM, SMALL = "room?triangles=3000", Picture(vc.Whitted(n_vpls=16), AQVC, (80, 50))
QUICK = (
    Case("quantized cache, 80x50", SMALL, SMALL_ROOM),
    Case("2 corrected passes, 80x50", partial(passes, size=(80, 50)), SMALL_ROOM),
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
    differ = sum(found.tobytes() != answers[1].tobytes() for found in answers.values())
    what = f"{case.name}: numbers of threads whose answers differ from those of one"
    trial.check(what, differ, 0)

"""`viscache bench aligned`: the engine that is chosen for aligned rays, against Embree."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt

import viscache as vc
from viscache.vlf import trace_aligned
from viscache_lab.experiment import BENCHES, Trial
from viscache_lab.experiment.amounts import turns

#: Scenes whose measurements set the prices of `vlf/engine_choice.cpp`: built-in specs, or files
#: in the folder of scenes by others.
FITTED = (
    "classroom/scene.xml",
    "veach-ajar/scene.pbrt",
    "scans/stanford_bunny.ply",
    "gltf-pine/scene.gltf",
    "cornell-box/scene.xml",
    "room?triangles=200000",
    "random_triangles?triangles=100000",
    "church",
    "apartment?triangles=300000",
    "bumpy_spheres?triangles=600000",
    "mushrooms?triangles=100000",
    "courtyard?triangles=400000",
)
#: Scenes that were not used for fitting.
HELD_OUT = (
    "living-room/scene.xml",
    "sponza-dabrovic/scene.xml",
    "sanmiguel-part/scene.xml",
    "gltf-balloon/scene.gltf",
    "scans/happy_buddha_30k.ply",
    "bumpy_spheres?triangles=15000",
    "conference?triangles=100000",
    "garden?triangles=300000",
    "garage?triangles=150000",
    "classroom_like",
    "hairball?triangles=300000",
    "cube_on_plane",
)
#: Length of the rays over the diagonal of the scene's bounds.
DISTANCES = (0.01, 0.05, 0.2, math.inf)
#: Rays that pass an edge within rounding may be answered differently.
DIFFERING = 3e-5
GOAL = 0.95


@dataclass(frozen=True, kw_only=True, slots=True)
class Case:
    """A picture of one scene, with aligned rays of one length."""

    size: tuple[int, int]
    n_directions: int
    distance: float

    @property
    def label(self) -> str:
        """The name in figures."""
        far = "all" if self.distance == math.inf else f"{100 * self.distance:g} %"
        return f"{self.size[0]}x{self.size[1]}, {self.n_directions} directions, {far}"


CASES = (
    *(Case(size=(160, 100), n_directions=513, distance=d) for d in DISTANCES),
    *(Case(size=(160, 100), n_directions=33, distance=d) for d in DISTANCES),
    Case(size=(320, 200), n_directions=513, distance=0.05),
    *(Case(size=(640, 400), n_directions=33, distance=d) for d in (0.05, math.inf)),
)
QUICK_SCENES = ("bumpy_spheres?triangles=15000", "classroom_like")
QUICK_CASES = tuple(Case(size=(64, 40), n_directions=129, distance=d) for d in (0.05, math.inf))


@BENCHES.add(
    "aligned",
    "the engine chosen for aligned rays against Embree, in scenes not used to fit",
    note="one thread; Embree: packets of 16 in the order for the number of points and triangles."
    " ours: engine=auto, with the time that the choice takes. Both include sorting the points.",
)
def aligned(trial: Trial) -> None:
    """Every case of the held-out scenes: engine "auto" against engine "embree"."""
    for spec, scene in trial.scenes(QUICK_SCENES if trial.quick else HELD_OUT):
        points: dict[tuple[int, int], Any] = {}
        for case in QUICK_CASES if trial.quick else CASES:
            if case.size not in points:
                points[case.size] = eye_points(scene, case.size)
            _compare(
                trial, f"{spec.partition('?')[0]} {case.label}", scene, case, points[case.size]
            )
    ratios = [f["ratio"] for f in trial.figures]
    if ratios:
        trial.figure("worst case vs embree", min(ratios), "", ratios=[min(ratios)], goal=GOAL)


def eye_points(
    scene: vc.Scene, size: tuple[int, int]
) -> tuple[npt.NDArray[np.float32], npt.NDArray[np.float32]]:
    """Positions and normals of a picture's eye points."""
    eyes = vc.connections(scene, vc.Direct(), size=size).eyes
    return np.ascontiguousarray(eyes.positions), np.ascontiguousarray(eyes.normals)


def rays_of(scene: vc.Scene, distance: float) -> float:
    """The length of rays in scene units."""
    low, high = np.asarray(scene.bounds)
    return float(distance * np.linalg.norm(high - low))


def _compare(
    trial: Trial,
    label: str,
    scene: vc.Scene,
    case: Case,
    points: tuple[npt.NDArray[np.float32], npt.NDArray[np.float32]],
) -> None:
    t_max, n_rays = rays_of(scene, case.distance), len(points[0]) * case.n_directions
    trace = partial(trace_aligned, scene, *points, case.n_directions, t_max=t_max, threads=1)
    scene.aligned_batch(), scene.caster()
    runs = {engine: partial(trace, engine=engine) for engine in ("auto", "embree")}
    samples, rows = turns(runs, trial.repeats(3, 2))
    trial.ratio(
        f"{label} vs embree",
        samples["auto"],
        samples["embree"],
        work=n_rays,
        goal=GOAL,
        points=len(points[0]),
        triangles=scene.triangles,
        engine=rows["auto"].engine,
        reason=rows["auto"].reason,
    )
    unlike = np.bitwise_count(rows["auto"].bits ^ rows["embree"].bits).sum() / n_rays
    trial.check(f"{label}: share unlike embree", float(unlike), DIFFERING)

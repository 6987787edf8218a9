"""`viscache bench vlf-ao`: ambient occlusion along shared directions, against Embree."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

import viscache as vc
from viscache.correlation import DirectionSet, surface_points, visibility_rows
from viscache.scenes.sources import made_by_others
from viscache.vlf import direction_frames, trace_aligned
from viscache.vlf.aligned import embree_rows
from viscache_lab.bench.frames import g_buffer
from viscache_lab.experiment import BENCHES, Trial
from viscache_lab.experiment.amounts import build_scene, fastest, frame_clock, turns

#: Axis by axis with packets of neighbouring points, or point by point with packets of axes.
PLANS = tuple((by_axis, w, c) for by_axis in (True, False) for w in (8, 16) for c in (False, True))
#: Rays that pass an edge within rounding may be answered differently.
DIFFERING = 1e-5
THREADS = 2
ENGINES: tuple[Literal["auto", "embree"], ...] = ("auto", "embree")


@dataclass(frozen=True, kw_only=True, slots=True)
class Case:
    """A square image of one scene from its camera; one ray per pixel with a hit and per axis."""

    name: str
    spec: str
    side: int
    goal: float
    n_directions: int = 513

    @property
    def label(self) -> str:
        """The name in figures."""
        return f"AO {self.name} {self.side}x{self.side}"


CASES = (
    Case(name="spheres-15k", spec="bumpy_spheres?triangles=15000", side=512, goal=2.5),
    Case(name="spheres-100k", spec="bumpy_spheres?triangles=100000", side=1024, goal=2.0),
    Case(name="spheres-600k", spec="bumpy_spheres?triangles=600000", side=1024, goal=1.3),
    Case(name="random-100k", spec="random_triangles?triangles=100000", side=256, goal=0.95),
    Case(name="spheres-600k", spec="bumpy_spheres?triangles=600000", side=128, goal=0.95),
    Case(name="spheres-600k", spec="bumpy_spheres?triangles=600000", side=64, goal=0.95),
    Case(name="room-200k", spec="room?triangles=200000", side=256, goal=0.95),
)
QUICK_CASES = (
    Case(
        name="spheres-3k", spec="bumpy_spheres?triangles=3000", side=64, goal=0.95, n_directions=129
    ),
    Case(
        name="spheres-100k",
        spec="bumpy_spheres?triangles=100000",
        side=16,
        goal=0.95,
        n_directions=129,
    ),
)

#: The rows of the correlation statistics: 9216 directions over the sphere from side² points.
ROWS = (
    Case(name="spheres-15k", spec="bumpy_spheres?triangles=15000", side=128, goal=1.15),
    Case(name="spheres-100k", spec="bumpy_spheres?triangles=100000", side=64, goal=0.95),
)
QUICK_ROWS = (Case(name="spheres-3k", spec="bumpy_spheres?triangles=3000", side=48, goal=0.9),)


@BENCHES.add("vlf-ao", "ambient occlusion along shared axes against the best of Embree's orders")
def vlf_ao(trial: Trial) -> None:
    """Every case: the engine of the lowest predicted cost against the fastest of Embree's plans."""
    scenes: dict[str, vc.Scene] = {}
    for case in QUICK_CASES if trial.quick else CASES:
        scene = scenes.setdefault(case.spec, build_scene(case.spec))
        _compare(trial, case, scene, 2 if trial.quick else 3)
    for case in QUICK_ROWS if trial.quick else ROWS:
        _compare_rows(trial, case, scenes.setdefault(case.spec, build_scene(case.spec)))
    if not trial.quick:
        living_room(trial)
    trial.notes.append(
        "embree: loops over rtcOccluded8/16 with either traversal flag, axis by axis over packets"
        " of neighbouring points or point by point over packets of axes, whichever is fastest;"
        " robust scene flag, the same points in the same order, two threads on both sides. ours:"
        " engine=auto, which is reported with its reason; the batch is built beforehand, as"
        " Embree's structure is; everything per call is in the time."
    )


def _compare(trial: Trial, case: Case, scene: vc.Scene, repeats: int) -> None:
    points, normals = g_buffer(scene, case.side)
    frames = direction_frames(case.n_directions)
    caster = scene.caster()
    scene.aligned_batch()
    plan = _best_plan(caster, points, normals, frames)
    given = (scene, points, normals, case.n_directions)
    runs: dict[str, Callable[[], Any]] = {
        "ours": partial(trace_aligned, *given, threads=THREADS),
        "embree": partial(_embree, caster, points, normals, frames, plan),
    }
    found = turns(runs, repeats, warm_up=False)
    samples, rows = found.samples, found.answers["ours"]
    order = "by axis" if plan[0] else "by point"
    trial.ratio(
        f"{case.label} vs embree",
        samples["ours"],
        samples["embree"],
        work=len(points) * case.n_directions,
        goal=case.goal,
        plan=f"{order}, {plan[1]}{' coherent' if plan[2] else ''}",
        points=len(points),
        triangles=scene.triangles,
        engine=rows.engine,
        reason=rows.reason,
    )
    rays = len(points) * case.n_directions
    differing = _ones(rows.bits ^ found.answers["embree"]) / rays
    trial.check(f"{case.label}: share unlike embree", differing, DIFFERING)
    free = _ones(rows.bits) / rays
    trial.check(f"{case.label}: nothing traced", float(not 0 <= free < 1), 0)


def _compare_rows(trial: Trial, case: Case, scene: vc.Scene) -> None:
    """Rows of visibility: the chosen engine against Embree in its faster packet order."""
    label = f"rows {case.name} {case.side**2} points"
    at, directions = surface_points(scene, case.side**2), DirectionSet()
    scene.aligned_batch(), scene.caster()
    every = partial(visibility_rows, scene, at, directions, threads=THREADS)
    found = turns({engine: partial(every, engine=engine) for engine in ENGINES}, 3)
    samples, rows = found.samples, found.answers
    n_rays = rows["auto"].n_rays
    trial.ratio(
        f"{label} vs embree",
        samples["auto"],
        samples["embree"],
        work=n_rays,
        goal=case.goal,
        points=len(at.positions),
        triangles=scene.triangles,
        engine=rows["auto"].engine,
        reason=rows["auto"].reason,
    )
    differing = _ones(rows["auto"].bits ^ rows["embree"].bits) / n_rays
    trial.check(f"{label}: share unlike embree", differing, DIFFERING)
    trial.check(f"{label}: nothing traced", float(n_rays == 0), 0)


def living_room(trial: Trial, side: int = 1024, repeats: int = 3) -> None:
    """A whole frame of a closed room: camera rays, shadow rays, sums."""
    label = f"AO living-room {side}x{side} frame"
    path = made_by_others("living-room/scene.xml")
    if path is None:
        trial.skip(f"{label} vs embree", "VISCACHE_SCENES holds no living-room/scene.xml")
        return
    scene = vc.load_scene(path)
    light = vc.AmbientOcclusion(n_samples=513, max_distance=None, directions="shared")
    whole = partial(vc.render, scene, size=(side, side), threads=THREADS)
    runs = {engine: partial(whole, replace(light, engine=engine)) for engine in ENGINES}
    found = turns(runs, repeats, clock=frame_clock)
    samples, frames = found.samples, found.answers
    trial.ratio(
        f"{label} vs embree",
        samples["auto"],
        samples["embree"],
        goal=2.0,
        plan="by axis, 16, flag by width",
        engine=frames["auto"].parameters["engine"],
    )
    difference = np.abs(frames["auto"].image - frames["embree"].image).mean()
    trial.check(f"{label}: mean difference to embree's", float(difference), DIFFERING)


def _ones(bits: npt.NDArray[np.uint64]) -> int:
    return int(np.unpackbits(bits.view(np.uint8)).sum())


def _embree(
    caster: Any,
    points: npt.NDArray[np.float32],
    normals: npt.NDArray[np.float32],
    frames: npt.NDArray[np.float32],
    plan: tuple[bool, int, bool],
) -> npt.NDArray[np.uint64]:
    by_axis, width, coherent = plan
    return embree_rows(
        caster,
        points,
        normals,
        frames,
        by_axis=by_axis,
        width=width,
        coherent=coherent,
        threads=THREADS,
    )


def _best_plan(
    caster: Any,
    points: npt.NDArray[np.float32],
    normals: npt.NDArray[np.float32],
    frames: npt.NDArray[np.float32],
) -> tuple[bool, int, bool]:
    """The fastest of the plans on 16 of the axes."""
    some = np.ascontiguousarray(frames[:: max(1, len(frames) // 16)][:16])
    return fastest({p: partial(_embree, caster, points, normals, some, p) for p in PLANS})

"""`viscache bench vlf-ao`: ambient occlusion along shared directions, against Embree."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from itertools import product
from typing import Any, Literal, TypeAlias

import numpy as np
import numpy.typing as npt

import viscache as vc
from viscache.correlation import DirectionSet, surface_points, visibility_rows
from viscache.vlf import direction_frames, trace_aligned
from viscache.vlf.aligned import embree_rows
from viscache_lab.bench.ray_sets import g_buffer
from viscache_lab.experiment import BENCHES, Trial
from viscache_lab.experiment.amounts import Sample, fastest, frame_clock, turns

#: Axis by axis with packets of neighbouring points, or point by point with packets of axes.
PLANS = [
    {"by_axis": by_axis, "width": width, "coherent": coherent}
    for by_axis, width, coherent in product((True, False), (8, 16), (False, True))
]
#: Rays that pass an edge within rounding may be answered differently.
DIFFERING = 1e-5
THREADS = 2
Bits: TypeAlias = npt.NDArray[np.uint64]
ENGINES: tuple[Literal["auto", "embree"], ...] = ("auto", "embree")


@dataclass(frozen=True, kw_only=True, slots=True)
class Case:
    """Rays along shared directions: of a square image ("AO"), its frame, or of points ("rows")."""

    title: str
    scene: str
    side: int
    goal: float
    kind: Literal["AO", "rows", "frame"] = "AO"
    n_directions: int = 513

    @property
    def name(self) -> str:
        """The name in figures."""
        if self.kind == "rows":
            return f"rows {self.title} {self.side**2} points"
        frame = " frame" if self.kind == "frame" else ""
        return f"AO {self.title} {self.side}x{self.side}{frame}"


SPHERES = "bumpy_spheres?triangles="
CASES = (
    Case(title="spheres-15k", scene=f"{SPHERES}15000", side=512, goal=2.5),
    Case(title="spheres-100k", scene=f"{SPHERES}100000", side=1024, goal=2.0),
    Case(title="spheres-600k", scene=f"{SPHERES}600000", side=1024, goal=1.3),
    Case(title="random-100k", scene="random_triangles?triangles=100000", side=256, goal=0.95),
    Case(title="spheres-600k", scene=f"{SPHERES}600000", side=128, goal=0.95),
    Case(title="spheres-600k", scene=f"{SPHERES}600000", side=64, goal=0.95),
    Case(title="room-200k", scene="room?triangles=200000", side=256, goal=0.95),
    Case(title="spheres-15k", scene=f"{SPHERES}15000", side=128, goal=1.15, kind="rows"),
    Case(title="spheres-100k", scene=f"{SPHERES}100000", side=64, goal=0.95, kind="rows"),
    Case(title="living-room", scene="living-room/scene.xml", side=1024, goal=2.0, kind="frame"),
)
QUICK = (
    Case(title="spheres-3k", scene=f"{SPHERES}3000", side=64, goal=0.95, n_directions=129),
    Case(title="spheres-100k", scene=f"{SPHERES}100000", side=16, goal=0.95, n_directions=129),
    Case(title="spheres-3k", scene=f"{SPHERES}3000", side=48, goal=0.9, kind="rows"),
)


@BENCHES.add(
    "vlf-ao",
    "ambient occlusion along shared axes against the best of Embree's orders",
    cases=CASES,
    quick_cases=QUICK,
    note="embree: loops over rtcOccluded8/16 with either traversal flag, axis by axis over packets"
    " of neighbouring points or point by point over packets of axes, whichever is fastest;"
    " robust scene flag, the same points in the same order, two threads on both sides. ours:"
    " engine=auto, which is reported with its reason; the batch is built beforehand, as"
    " Embree's structure is; everything per call is in the time.",
)
def vlf_ao(trial: Trial, case: Case, scene: vc.Scene) -> None:
    """The engine of the lowest predicted cost against the fastest of Embree's plans."""
    scene.aligned_batch(), scene.caster()
    {"AO": _picture, "rows": _rows, "frame": _frame}[case.kind](trial, case, scene)


def _picture(trial: Trial, case: Case, scene: vc.Scene) -> None:
    points = g_buffer(scene, case.side)
    frames = direction_frames(case.n_directions)
    embree = partial(embree_rows, scene.caster(), *points, threads=THREADS)
    some = np.ascontiguousarray(frames[:: max(1, len(frames) // 16)][:16])
    plan = PLANS[fastest({i: partial(embree, some, **p) for i, p in enumerate(PLANS)})]
    runs: dict[str, Callable[[], Any]] = {
        "auto": partial(trace_aligned, scene, *points, case.n_directions, threads=THREADS),
        "embree": partial(embree, frames, **plan),
    }
    samples, found = turns(runs, trial.repeats(3, 2), warm_up=False)
    order = "by axis" if plan["by_axis"] else "by point"
    n_rays = len(points[0]) * case.n_directions
    _figure(
        trial,
        case,
        samples,
        found["auto"],
        work=n_rays,
        plan=f"{order}, {plan['width']}{' coherent' if plan['coherent'] else ''}",
        points=len(points[0]),
        triangles=scene.triangles,
    )
    _check(trial, case, found["auto"].bits, found["embree"], n_rays)


def _rows(trial: Trial, case: Case, scene: vc.Scene) -> None:
    at, directions = surface_points(scene, case.side**2), DirectionSet()
    every = partial(visibility_rows, scene, at, directions, threads=THREADS)
    samples, found = turns({engine: partial(every, engine=engine) for engine in ENGINES}, 3)
    auto = found["auto"]
    more = {"points": len(at.positions), "triangles": scene.triangles}
    _figure(trial, case, samples, auto, work=auto.n_rays, **more)
    _check(trial, case, auto.bits, found["embree"].bits, auto.n_rays)


def _frame(trial: Trial, case: Case, scene: vc.Scene) -> None:
    """Camera rays, shadow rays and sums of a closed room."""
    light = vc.AmbientOcclusion(n_samples=case.n_directions, max_distance=None, directions="shared")
    whole = partial(vc.render, scene, size=(case.side, case.side), threads=THREADS)
    runs = {engine: partial(whole, replace(light, engine=engine)) for engine in ENGINES}
    samples, frames = turns(runs, trial.repeats(3), clock=frame_clock)
    auto, embree = (frames[engine] for engine in ENGINES)
    trial.ratio(
        f"{case.name} vs embree",
        samples["auto"],
        samples["embree"],
        goal=case.goal,
        plan="by axis, 16, flag by width",
        engine=auto.parameters["engine"],
    )
    difference = float(np.abs(auto.image - embree.image).mean())
    trial.check(f"{case.name}: mean difference to embree's", difference, DIFFERING)


def _figure(
    trial: Trial, case: Case, samples: dict[Any, list[Sample]], ours: Any, **more: Any
) -> None:
    """Our time against Embree's, with the engine that was chosen."""
    more |= {"goal": case.goal, "engine": ours.engine, "reason": ours.reason}
    trial.ratio(f"{case.name} vs embree", samples["auto"], samples["embree"], **more)


def _check(trial: Trial, case: Case, ours: Bits, theirs: Bits, n_rays: int) -> None:
    differing = float(np.bitwise_count(ours ^ theirs).sum()) / n_rays
    trial.check(f"{case.name}: share unlike embree", differing, DIFFERING)
    free = float(np.bitwise_count(ours).sum()) / max(1, n_rays)
    trial.check(f"{case.name}: nothing traced", float(not 0 <= free < 1 or n_rays == 0), 0)

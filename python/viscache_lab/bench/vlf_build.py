"""`viscache bench vlf-build`: fields built, their single rays against Embree, and moved objects."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

import viscache as vc
from viscache.vlf.dynamic import DynamicField
from viscache_lab.bench.ray_sets import RaySet, make_ray_set
from viscache_lab.cases.beams import chords
from viscache_lab.cases.moving_object import STOPS, ball, with_object
from viscache_lab.experiment import BENCHES, Trial
from viscache_lab.experiment.amounts import fastest, turns

UPDATED, QUICK_UPDATED = "bumpy_spheres?triangles=100000", "bumpy_spheres?triangles=3000"
MOVED = vc.Vlf(n_tiles=128, bsp_depth=3, head_room=1.25, max_bytes=4 << 30)
QUICK_MOVED = vc.Vlf(n_directions=33, n_tiles=64, bsp_depth=3, head_room=1.25)
#: Triangles of the object that moves.
SIZES, QUICK_SIZES = (100, 1000, 10_000), (100,)
CHORDS, QUICK_CHORDS = 20_000, 2000
REPEATS = 2
#: Allowed share of rays whose nearest hit differs from that of the rebuilt field.
DIFFERING = 1e-4


def compare_updates(trial: Trial, scene: vc.Scene) -> None:
    """CPU seconds of an update, in both modes, and of a field built with the object in place."""
    settings, sizes = (QUICK_MOVED, QUICK_SIZES) if trial.quick else (MOVED, SIZES)
    beams = chords(scene, QUICK_CHORDS if trial.quick else CHORDS)
    modes: tuple[Literal["overlay", "in_place"], ...] = ("overlay", "in_place")
    for mode in modes:
        field = DynamicField(scene, settings, mode=mode)
        for size in sizes:
            vertices, triangles = ball(size, (0.0, 0.5, 0.0))
            number = field.insert(vertices, triangles)
            moved = with_object(scene, vertices + np.array(STOPS[REPEATS - 1]), triangles)
            stops = iter(STOPS)
            runs: dict[str, Callable[[], Any]] = {
                "update": partial(_move, field, number, stops),
                "rebuild": partial(settings.build, moved),
            }
            samples, built = turns(runs, REPEATS, warm_up=False)
            label = f"field of {scene.triangles} triangles, {mode}, {len(triangles)} moved"
            trial.ratio(f"{label} vs rebuild", samples["update"], samples["rebuild"])
            found = field.intersect(beams.origins, beams.directions).t
            expected = built["rebuild"].intersect(beams.origins, beams.directions)[0]
            differ = float(np.mean(~np.isclose(found, expected, rtol=1e-5, atol=0)))
            trial.check(f"{label}: share unlike the field built anew", differ, DIFFERING)
            field.delete(number)


def _move(field: DynamicField, number: int, stops: Iterator[tuple[float, float, float]]) -> None:
    matrix = np.eye(4)
    matrix[:3, 3] = next(stops)
    field.transform(number, matrix)


SCENES = (
    "random_triangles?triangles=10000&edge_factor=1",
    "bumpy_spheres?triangles=15000",
    "classroom_like",
)
QUICK_SCENES = ("bumpy_spheres?triangles=1500",)
FIELD, QUICK_FIELD = vc.Vlf(bsp_depth=3, max_bytes=4 << 30), vc.Vlf(n_directions=33, n_tiles=64)
#: Depths and leaf sizes of the BSP; each ray set uses the fastest combination.
DEPTHS, LEAVES = (16, 20, 24), (4, 8, 16)
TREES = tuple(vc.Bsp(max_depth=d, leaf_size=n, kernel="wald") for d in DEPTHS for n in LEAVES)
QUICK_TREES = (vc.Bsp(kernel="wald"),)
#: The paper's single-ray tracer must reach this share of Embree's single-ray speed.
GUARD = 0.25
EDGE_TOLERANCE = 1e-3
RAYS, QUICK_RAYS = 100_000, 4_000


@BENCHES.add(
    "vlf-build",
    "building visibility fields; the paper's tracers against Embree ray by ray",
    cases=(*SCENES, UPDATED),
    quick_cases=(*QUICK_SCENES, QUICK_UPDATED),
    note="Embree ray by ray: rtcIntersect1 and rtcOccluded1, robust; Bsp: the fastest of a grid, "
    "Wald's triangle test as in the paper. A ray of the BSP "
    "visits the nodes counted in nodes_per_ray, one load after the other.",
)
def vlf_build(trial: Trial, spec: str, scene: vc.Scene) -> None:
    """Build time and memory of fields; rays per second of the paper's tracers on one thread."""
    if spec in (UPDATED, QUICK_UPDATED):
        compare_updates(trial, scene)
        return
    settings = QUICK_FIELD if trial.quick else FIELD
    _compare_builds(trial, scene, settings)
    field = settings.build(scene)
    for name in ("camera", "hemi"):
        rays = make_ray_set(scene, name, QUICK_RAYS if trial.quick else RAYS)
        _compare_rays(trial, scene, rays, field)


def _compare_builds(trial: Trial, scene: vc.Scene, settings: vc.Vlf) -> None:
    runs: dict[str, Callable[[], Any]] = {
        "one thread": partial(settings.build, scene, 1),
        "two threads": partial(settings.build, scene, 2),
        "embree": partial(vc.Embree().build, scene, 0),
    }
    samples, built = turns(runs, trial.repeats(3), warm_up=False)
    label = f"field {_label(scene)}, l {settings.n_directions}, n {settings.n_tiles}"
    stats = built["one thread"].stats
    trial.ratio(
        f"{label}: build on two threads vs one",
        samples["two threads"],
        samples["one thread"],
        clock="wall_s",
        bytes=stats["bytes"],
    )
    trial.ratio(f"{label}: build vs embree", samples["one thread"], samples["embree"])
    changed = stats != built["two threads"].stats
    trial.check(f"{label}: threads change the field", float(changed), 0)


def _compare_rays(trial: Trial, scene: vc.Scene, r: RaySet, field: Any) -> None:
    caster = scene.caster()
    rays = (r.origins, r.directions)
    some = [a[:10_000] for a in rays]
    trees: list[Any] = [t.build(scene) for t in (QUICK_TREES if trial.quick else TREES)]
    bsp = fastest({tree: partial(tree.intersect, *some, 1) for tree in trees})
    jobs: dict[str, dict[str, Callable[[], npt.NDArray[Any]]]] = {
        "any-hit": {
            "embree": lambda: caster.bare_occluded(*rays, np.inf, 1, threads=1),
            "bsp": lambda: bsp.occluded(*rays, np.inf, 1),
            "field": lambda: field.occluded(*rays, np.inf, 1),
        },
        "nearest": {
            "embree": lambda: caster.bare_intersect(*rays, threads=1),
            "bsp": lambda: bsp.intersect(*rays, 1)[0],
            "field": lambda: field.intersect(*rays, 1)[0],
        },
    }
    steps = bsp.count_steps(r.origins[:2000], r.directions[:2000])
    of_bsp = {f"{what}_per_ray": n / len(r.origins[:2000]) for what, n in steps.items()}
    of_bsp |= {name: bsp.stats[name] for name in ("max_depth", "bytes")}
    for job, tracers in jobs.items():
        samples, answers = turns(tracers, trial.repeats(5, 2))
        for name in ("bsp", "field"):
            label = f"{name} {_label(scene)} {r.name} {job}"
            trial.ratio(
                f"{label} vs embree1",
                samples[name],
                samples["embree"],
                work=len(r),
                goal=GUARD if name == "bsp" else None,
                **(of_bsp if name == "bsp" else {}),
            )
            both = (answers[name], answers["embree"])
            found, truth = (a if a.dtype == bool else np.isfinite(a) for a in both)
            differing = float(np.mean(found != truth))
            trial.check(f"{label}: share unlike embree", differing, EDGE_TOLERANCE)


def _label(scene: vc.Scene) -> str:
    return f"{(scene.spec or scene.name).partition('?')[0]} {scene.triangles}"

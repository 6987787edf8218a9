"""`viscache bench vlf-build`: building the visibility field, and its single rays against Embree."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt

import viscache as vc
from viscache_lab.bench.ray_sets import RaySet, make_ray_set
from viscache_lab.bench.vlf_update import QUICK_UPDATED, UPDATED, compare_updates
from viscache_lab.experiment import BENCHES, Trial
from viscache_lab.experiment.amounts import timed, turns

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
    trees = QUICK_TREES if trial.quick else TREES
    bsp = min((t.build(scene) for t in trees), key=lambda tree: _trial(tree, r))
    rays = (r.origins, r.directions)
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
            found, truth = (a if a.dtype == bool else np.isfinite(a)
                            for a in (answers[name], answers["embree"]))  # fmt: skip
            differing = float(np.mean(found != truth))
            trial.check(f"{label}: share unlike embree", differing, EDGE_TOLERANCE)


def _trial(tree: Any, r: RaySet) -> float:
    """CPU seconds of some of the rays."""
    n = min(len(r), 10_000)
    origins, directions = r.origins[:n], r.directions[:n]
    return min(timed(lambda: tree.intersect(origins, directions, 1))[0].cpu_s for _ in range(2))


def _label(scene: vc.Scene) -> str:
    return f"{(scene.spec or scene.name).partition('?')[0]} {scene.triangles}"

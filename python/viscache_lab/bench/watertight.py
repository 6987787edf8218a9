"""`viscache bench watertight`: rays that pass no vertex, against Embree's robust packets."""

from __future__ import annotations

from functools import partial

import numpy as np

import viscache as vc
from viscache_lab.bench.ray_sets import SETS, RaySet, make_ray_set
from viscache_lab.experiment import BENCHES, Trial
from viscache_lab.experiment.amounts import build_scene, turns

SCENES = (
    "room?triangles=200000",
    "hairball?triangles=300000",
    "random_triangles?triangles=100000",
    "courtyard?triangles=1000000",
)
QUICK_SCENES = ("room?triangles=20000", "random_triangles?triangles=5000")
#: Share of rays that robust packets may answer otherwise: those within rounding of an edge.
EDGE_TOLERANCE = 1e-3
CASTERS: dict[str, vc.Embree | vc.Bsp] = {
    "watertight": vc.Embree(watertight=True),
    "robust": vc.Embree(),
    "BSP": vc.Bsp(),
}


@BENCHES.add(
    "watertight", "any-hit rays that pass no vertex against Embree's robust packets and the BSP"
)
def watertight(trial: Trial) -> None:
    """Any hits of every scene and ray set: watertight against robust packets and the BSP."""
    for spec in QUICK_SCENES if trial.quick else SCENES:
        scene = build_scene(spec)
        for which in SETS:
            r = make_ray_set(scene, which, 50_000 if trial.quick else 250_000)
            _compare(
                trial,
                scene,
                f"{spec.partition('?')[0]} {scene.triangles}",
                r,
                2 if trial.quick else 5,
            )
    trial.notes.append(
        "Ratios below 1 are the price of gaps closed at vertices. The BSP has none either; its"
        " answers are the same, bit for bit."
    )


def _compare(trial: Trial, scene: vc.Scene, name: str, r: RaySet, repeats: int) -> None:
    rays = (r.origins, r.directions, r.t_max)
    runs = {name: partial(scene.occluded, *rays, rays=by) for name, by in CASTERS.items()}
    found = turns(runs, repeats)
    samples, answers = found.samples, found.answers
    label = f"{name} {r.name} any-hit"
    for other in ("robust", "BSP"):
        trial.ratio(
            f"{label}: watertight vs {other}", samples["watertight"], samples[other], work=len(r)
        )
        differing = float(np.mean(answers["watertight"] != answers[other]))
        limit = EDGE_TOLERANCE if other == "robust" else 0.0
        trial.check(f"{label}: share unlike {other}", differing, limit)

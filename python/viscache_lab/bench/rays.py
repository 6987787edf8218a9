"""`viscache bench rays`: any-hit rays from numpy arrays to a numpy array."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt

import viscache as vc
from viscache_lab.bench.peers import Peer, missing
from viscache_lab.bench.ray_sets import SETS, RaySet, make_ray_set
from viscache_lab.experiment import BENCHES, Trial
from viscache_lab.experiment.amounts import build_scene, fastest, turns

SCENES = (
    "room?triangles=200000",
    "hairball?triangles=1000000",
    "random_triangles?triangles=100000",
    "random_triangles?triangles=1000000",
    "courtyard?triangles=1000000",
)
QUICK_SCENES = ("room?triangles=20000", "random_triangles?triangles=5000")
#: Another program may answer rays differently that pass an edge within rounding.
EDGE_TOLERANCE = 1e-3
GOALS = {"embree-loop": 0.97, "mitsuba": 1.0, "embreex": 1.7}
PLANS = [(w, c) for w in (1, 4, 8, 16) for c in (False, True) if not (w == 1 and c)]


@BENCHES.add(
    "rays", "any-hit rays from numpy to numpy against a bare Embree loop, Mitsuba, embreex"
)
def rays(trial: Trial) -> None:
    """Every scene, ray set and baseline, with Embree's robust flag on all sides."""
    for spec in QUICK_SCENES if trial.quick else SCENES:
        scene = build_scene(spec)
        peers = {}
        for name in ("mitsuba", "embreex"):
            reason = missing(name, scene)
            if reason:
                trial.skip(f"{spec} vs {name}", reason)
            else:
                peers[name] = Peer(name, scene)
        try:
            for which in SETS:
                n = 50_000 if trial.quick else 500_000
                _compare(
                    trial,
                    scene,
                    spec,
                    make_ray_set(scene, which, n),
                    peers,
                    2 if trial.quick else 5,
                )
        finally:
            for peer in peers.values():
                peer.__exit__(None, None, None)
    trial.notes.append(
        "embree-loop: the best of loops over rtcOccluded1/4/8/16 with either traversal flag, same"
        " threads, same chunks. mitsuba: ray_test of its llvm variant. embreex: its one thread"
        " against all of ours, by the wall clock. Robust scene flag on all sides."
    )


def _compare(
    trial: Trial, scene: vc.Scene, spec: str, r: RaySet, peers: dict[str, Peer], repeats: int
) -> None:
    caster = scene.caster()
    width, coherent = _best_plan(caster, r)
    runs: dict[str, Callable[[], Any]] = {
        "ours": lambda: scene.occluded(r.origins, r.directions, r.t_max),
        "embree-loop": lambda: _loop(caster, r, width, coherent),
    }
    for name, peer in peers.items():
        peer.give(origins=r.origins, directions=r.directions, t_max=r.t_max)
        runs[name] = lambda peer=peer: peer.run({"job": "any_hit"})[0]  # type: ignore[misc]
    found_by = turns(runs, repeats)
    samples, answers = found_by.samples, found_by.answers
    for name, peer in peers.items():
        found = peer.result()["occluded"]
        # embreex answers 0 where a ray is blocked, −1 where it is free
        answers[name] = found == 0 if name == "embreex" else found.astype(bool)

    label = f"{spec.partition('?')[0]} {scene.triangles} {r.name} any-hit"
    for name in runs:
        if name == "ours":
            continue
        more: dict[str, Any] = {}
        if name == "embree-loop":
            more["plan"] = f"{width}{' coherent' if coherent else ''}"
        trial.ratio(
            f"{label} vs {name}",
            samples["ours"],
            samples[name],
            clock="wall_s" if name == "embreex" else "cpu_s",
            work=len(r),
            goal=GOALS[name],
            **more,
        )
        differing = float(np.mean(answers["ours"] != answers[name]))
        trial.check(
            f"{label}: share unlike {name}",
            differing,
            0 if name == "embree-loop" else EDGE_TOLERANCE,
        )
    blocked = float(answers["ours"].mean())
    trial.check(f"{label}: all or nothing blocked", float(blocked in (0.0,)), 0)


def _loop(caster: Any, r: RaySet, width: int, coherent: bool) -> npt.NDArray[np.bool_]:
    answers = caster.bare_occluded(r.origins, r.directions, r.t_max, width, coherent=coherent)
    return np.asarray(answers)


def _best_plan(caster: Any, r: RaySet) -> tuple[int, bool]:
    """The packet width and flag of the fastest bare loop on this set."""
    return fastest({plan: partial(_loop, caster, r, *plan) for plan in PLANS})

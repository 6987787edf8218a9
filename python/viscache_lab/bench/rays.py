"""`viscache bench rays`: any-hit rays from numpy arrays to a numpy array."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import ExitStack
from functools import partial
from typing import Any

import numpy as np

import viscache as vc
from viscache_lab.bench.peers import Peer, blocked, missing, time_of
from viscache_lab.bench.ray_sets import SETS, RaySet, make_ray_set
from viscache_lab.experiment import BENCHES, Trial
from viscache_lab.experiment.amounts import fastest, turns

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
    "rays",
    "any-hit rays from numpy to numpy against a bare Embree loop, Mitsuba, embreex",
    cases=SCENES,
    quick_cases=QUICK_SCENES,
    note="embree-loop: the best of loops over rtcOccluded1/4/8/16 with either traversal flag, same"
    " threads, same chunks. mitsuba: ray_test of its llvm variant. embreex: its one thread"
    " against all of ours, by the wall clock. Robust scene flag on all sides.",
)
def rays(trial: Trial, spec: str, scene: vc.Scene) -> None:
    """Every ray set and baseline, with Embree's robust flag on all sides."""
    peers = {}
    with ExitStack() as running:
        for name in ("mitsuba", "embreex"):
            reason = missing(name, scene)
            if reason:
                trial.skip(f"{spec} vs {name}", reason)
            else:
                peers[name] = running.enter_context(Peer(name, scene))
        for which in SETS:
            r = make_ray_set(scene, which, 50_000 if trial.quick else 500_000)
            label = f"{spec.partition('?')[0]} {scene.triangles} {r.name} any-hit"
            _compare(trial, label, scene, r, peers)


def _compare(
    trial: Trial, label: str, scene: vc.Scene, r: RaySet, peers: Mapping[str, Peer]
) -> None:
    loop = partial(scene.caster().bare_occluded, r.origins, r.directions, r.t_max)
    width, coherent = fastest({(w, c): partial(loop, w, coherent=c) for w, c in PLANS})
    runs: dict[str, Callable[[], Any]] = {
        "ours": partial(scene.occluded, r.origins, r.directions, r.t_max),
        "embree-loop": partial(loop, width, coherent=coherent),
    }
    for name, peer in peers.items():
        peer.give(origins=r.origins, directions=r.directions, t_max=r.t_max)
        runs[name] = partial(time_of, peer, "any_hit")
    samples, answers = turns(runs, trial.repeats(5, 2))
    answers |= {name: blocked(peer.result()["occluded"], name) for name, peer in peers.items()}
    for name in list(runs)[1:]:
        plan = {"plan": f"{width}{' coherent' if coherent else ''}"}
        trial.ratio(
            f"{label} vs {name}",
            samples["ours"],
            samples[name],
            clock="wall_s" if name == "embreex" else "cpu_s",
            work=len(r),
            goal=GOALS[name],
            **(plan if name == "embree-loop" else {}),
        )
        differing = float(np.mean(answers["ours"] != answers[name]))
        limit = 0 if name == "embree-loop" else EDGE_TOLERANCE
        trial.check(f"{label}: share unlike {name}", differing, limit)
    trial.check(f"{label}: all or nothing blocked", float(not answers["ours"].any()), 0)

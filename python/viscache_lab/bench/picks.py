"""`viscache bench picks`: error over time where each eye point picks some of the shared lights.

All frames have lights and eye samples of their own. The converged picture is the mean of exact
frames of other seeds, so it has other lights, too. All ways but the cache are unbiased: the error
of the mean of k frames is the k-th part, and gains hold for any number of passes. For the cache
they hold for one frame alone.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt

import viscache as vc
from viscache_lab.bench.errors import NOTE, error_over_time
from viscache_lab.experiment import BENCHES, Trial

Array = npt.NDArray[Any]


@dataclass(frozen=True, kw_only=True)
class Case:
    """A picture. A scene is a spec, or a folder of $VISCACHE_SCENES and a file in it."""

    name: str
    scene: str
    size: tuple[int, int] = (192, 120)
    spp: int = 1
    integrator: vc.Direct | vc.Whitted
    picks: tuple[int, ...] = (8, 16, 64)
    seeds: int = 12
    references: int = 24
    goals: Mapping[int, float]
    """Least gain by number of picks."""


# Of the lights that all eye points share alone: samples of their own have noise that no way changes
VPLS = vc.Whitted(n_vpls=1024, n_area=0, n_environment=0, n_brdf=0)
LAMPS = vc.Direct(n_area=0, n_environment=0, n_brdf=0)
CASES = (
    Case(name="room", scene="room?triangles=200000", integrator=VPLS, goals={8: 3, 16: 3, 64: 2}),
    Case(name="apartment", scene="apartment", integrator=VPLS, goals={16: 3}),
    Case(name="conference", scene="conference", integrator=VPLS, goals={16: 3}),
    Case(name="living-room", scene="living-room/scene.xml", integrator=VPLS, goals={16: 1}),
    Case(name="sponza", scene="sponza-dabrovic/scene.xml", integrator=VPLS, goals={16: 1}),
    Case(
        name="room, 24 lamps",
        scene="room?triangles=200000",
        spp=4,
        integrator=LAMPS,
        picks=(2, 4, 8),
        goals={4: 1},
    ),
)
QUICK = (
    Case(
        name="room, 48×32",
        scene="room?triangles=3000",
        size=(48, 32),
        integrator=replace(VPLS, n_vpls=100),
        picks=(8,),
        seeds=8,
        references=8,
        goals={},
    ),
    Case(
        name="room, 24 lamps, 48×32",
        scene="room?triangles=3000",
        size=(48, 32),
        integrator=LAMPS,
        picks=(4,),
        seeds=8,
        references=8,
        goals={},
    ),
)


@BENCHES.add(
    "picks",
    "error over time: exact, cached, or a few lights picked by each eye point",
    cases=CASES,
    quick_cases=QUICK,
    note=NOTE.format("exact"),
)
def picks(trial: Trial, case: Case, scene: vc.Scene) -> None:
    """MSE · CPU time of exact frames over that of picks, of cached frames, and of both."""
    scene.caster()
    cached = {"visibility": vc.Aqvc()}
    corrected = {**cached, "use": "correct"}
    most = case.picks[-1]
    ways: dict[str, dict[str, Any]] = {
        "exact": {},
        "cache": cached,
        "corrected": corrected,
        **{f"{n} picks": {"pick": n} for n in case.picks},
        f"{most} picks, corrected": {"pick": most, **corrected},
    }
    error_over_time(
        trial,
        case.name,
        {way: partial(_render, case, scene, **options) for way, options in ways.items()},
        partial(_render, case, scene),
        seeds=case.seeds,
        references=case.references,
        goals={f"{n} picks": goal for n, goal in case.goals.items()},
        biased=("cache",),
    )


def _render(
    case: Case,
    scene: vc.Scene,
    seed: int,
    *,
    pick: int = 0,
    visibility: Any = None,
    use: Any = None,
) -> tuple[Array, float]:
    """Light on surfaces, without the noise of lamps' edges, and CPU seconds of the whole frame."""
    frame = vc.render(
        scene,
        replace(case.integrator, pick=pick),
        visibility=visibility or vc.Exact(),
        use=use,
        size=case.size,
        spp=case.spp,
        seed=seed,
        threads=1,
    )
    image = np.asarray(frame.image, np.float64) - frame.layers["emitted"]
    return image, float(frame.timings["cpu_s"])

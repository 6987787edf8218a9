"""`viscache bench picks`: error over time where each eye point picks some of the shared lights.

All frames have lights and eye samples of their own. The converged picture is the mean of exact
frames of other seeds, so it has other lights, too. All ways but the cache are unbiased: the error
of the mean of k frames is the k-th part, and gains hold for any number of passes. For the cache
they hold for one frame alone.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt

import viscache as vc
from viscache_lab.bench.errors import Errors, energy_z, gain_figure, seed_by_seed
from viscache_lab.experiment import BENCHES, Trial

Array = npt.NDArray[Any]

#: The largest |z| of the energy of picks against exact frames of the same seeds.
MOST_Z = 4.0
#: Seeds of frames of the converged picture start here.
FIRST_REFERENCE = 1000


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


@BENCHES.add("picks", "error over time: exact, cached, or a few lights picked by each eye point")
def picks(trial: Trial) -> None:
    """MSE · CPU time of exact frames over that of picks, of cached frames, and of both."""
    for case, scene in trial.scenes(QUICK if trial.quick else CASES):
        measure(trial, case, scene)
    trial.notes.append(
        "Ratios: mean squared error times CPU seconds, exact over the other, with the 95 % interval"
        " of a bootstrap over seeds. Values: the same of the other, relative to the squared mean."
        " gain_rel: by squared errors relative to each pixel, floor 5 % of the mean."
    )


def measure(trial: Trial, case: Case, scene: vc.Scene) -> None:
    """Let all ways take turns, seed by seed."""
    scene.caster()
    converged = np.stack([_render(case, scene, s)[0] for s in _reference_seeds(case)])
    errors = Errors(converged)
    corrected = {"visibility": vc.Aqvc(), "use": "correct"}
    ways: dict[str, dict[str, Any]] = {
        "exact": {},
        "cache": {"visibility": vc.Aqvc()},
        "corrected": corrected,
        **{f"{n} picks": {"pick": n} for n in case.picks},
        f"{case.picks[-1]} picks, corrected": {"pick": case.picks[-1], **corrected},
    }
    runs: dict[str, Callable[[int], Any]] = {
        way: partial(_render, case, scene, **options) for way, options in ways.items()
    }
    for run in runs.values():
        run(0)
    images, seconds = seed_by_seed(runs, case.seeds)
    found = {way: errors.of(stack) for way, stack in images.items()}
    for way, options in ways.items():
        if way == "exact":
            continue
        trial.figures.append(
            gain_figure(
                f"{case.name}: {way} vs exact",
                found,
                seconds,
                way,
                goal=None if "use" in options else case.goals.get(options.get("pick", 0)),
            )
        )
        if "pick" in options or "use" in options:
            z = energy_z(images[way] - images["exact"])
            trial.check(f"{case.name}: {way}, |z| of the energy", abs(z), MOST_Z)


def _reference_seeds(case: Case) -> range:
    return range(FIRST_REFERENCE, FIRST_REFERENCE + case.references)


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

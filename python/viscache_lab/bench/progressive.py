"""`viscache bench progressive`: error times time of passes, exact, plain, corrected and picked."""

from __future__ import annotations

import statistics
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

import viscache as vc
from viscache.passes.over_time import gain
from viscache_lab.bench.errors import differences, energy_z, persistent_z
from viscache_lab.experiment import BENCHES, Trial
from viscache_lab.experiment.amounts import student_t, turns

#: The cache of plain passes, for all scenes, and of corrected ones: the default.
PLAIN, CORRECTED = vc.Aqvc(c_e=10), vc.Aqvc()
#: Picks of each eye point, of the rival without a cache.
PICKS = 16
#: Limit of the energy's t value; it has 15 degrees of freedom.
LIMIT_Z = 4.0
#: Limits over many passes: of the energy's |z|, and of the persistent squared error in its
#: standard errors.
LIMIT_MANY, LIMIT_BIAS = 3.0, 3.0
#: Exact CPU seconds over those of corrected passes must be at least this where these cannot win.
NEVER_SLOWER = 1 / 1.03
#: Pictures of each way, one after the other: a ratio is that of a pair whose passes took turns.
TURNS = 5


@dataclass(frozen=True)
class Case:
    """A scene, and goals for corrected passes: nMSE and relMSE over packets, shafts and picks."""

    name: str
    scene: str
    packets: tuple[float, float] | None = None
    exact: tuple[float, float] | None = None
    picks: tuple[float, float] | None = None
    size: tuple[int, int] = (192, 192)
    n_vpls: int = 1024
    passes: int = 16
    reference: int = 16
    many: int = 64  # passes of a smaller picture that tell a bias
    many_size: tuple[int, int] = (48, 48)


CASES = (
    Case("room", "room?triangles=200000", (7, 5), (2.5, 2), (1.3, 1.3)),
    Case("apartment", "apartment?triangles=300000", (7, 5), (2.5, 2), (1.3, 1.3)),
    Case("conference", "conference", (7, 5), (2.5, 2), (1.3, 1.3)),
    Case("sponza", "sponza-dabrovic/scene.xml", (6, 6)),
    Case("living-room", "living-room/scene.xml", (4, 1.3)),
)
QUICK = (
    Case(
        "room", "room?triangles=3000", size=(48, 32), n_vpls=128, passes=6, reference=12, many=16,
        many_size=(32, 32),
    ),
)  # fmt: skip


@dataclass(frozen=True)
class CannotWin:
    """A picture whose lights corrections cannot win: their passes then cost as much as exact ones.

    It has a goal if it is large enough.
    """

    name: str
    scene: str
    light: vc.Direct | vc.Whitted
    size: tuple[int, int] = (160, 100)
    passes: int = 16
    goal: float | None = NEVER_SLOWER


def _alone(n: int) -> vc.Whitted:
    """N virtual lights and no samples of area lights or skies."""
    return vc.Whitted(n_vpls=n, n_area=0, n_environment=0, n_brdf=0)


OPEN_SKY = vc.Direct(n_area=0, environment="shared", n_environment=256, n_brdf=0)
CANNOT_WIN = (
    CannotWin("24 lamps", "room?triangles=200000", vc.Direct(n_area=0)),
    CannotWin("16 virtual lights", "garage", _alone(16)),
    CannotWin("32 virtual lights", "church", _alone(32)),
    CannotWin("own samples", "living-room/scene.xml", vc.Direct()),
    CannotWin("open sky", "courtyard", OPEN_SKY),
    CannotWin("light through a gap", "veach-ajar/scene.pbrt", vc.Whitted(n_vpls=256)),
)
SMALL = CannotWin("24 lamps", "room?triangles=3000", vc.Direct(n_area=0), (48, 32), 4, None)


@BENCHES.add(
    "progressive",
    "error times time of passes: exact, plain and corrected",
    cases=CASES + CANNOT_WIN,
    quick_cases=(*QUICK, SMALL),
    note="Passes take turns. Errors against two references: exact passes of other eye samples and"
    " the same lights. Their noise cancels. A ratio is MSE·CPU time of the second way over that"
    " of the first: above 1 the first is better. 'plain' keeps the cache's error, so its ratio"
    " falls with more passes. 'many passes': of a smaller picture, beside exact passes of the"
    " same samples.",
)
def progressive(trial: Trial, case: Case | CannotWin, scene: vc.Scene) -> None:
    """MSE·time of passes, against a picture of other eye samples; bias over many; time at worst."""
    if isinstance(case, CannotWin):
        never_slower(trial, case, scene)
    else:
        measure(trial, case, scene)
        bias(trial, case, scene)


def measure(trial: Trial, case: Case, scene: vc.Scene) -> None:
    """Let the methods take turns pass by pass."""
    light, picks = vc.Whitted(n_vpls=case.n_vpls), f"{PICKS} picks"
    settings: dict[str, dict[str, Any]] = {
        "packets": {"visibility": vc.Exact(engine="packets")},
        "exact": {"visibility": vc.Exact()},
        "plain": {"visibility": PLAIN, "use": "replace"},
        "corrected": {"visibility": CORRECTED, "use": "correct"},
        picks: {"visibility": vc.Exact(), "integrator": replace(light, pick=PICKS)},
    }
    ds = vc.passes_over_time(
        scene, light, settings, passes=case.passes, reference=case.reference, size=case.size
    )
    compared: list[tuple[str, str, tuple[float, float] | None]]
    compared = [(name, "packets", None) for name in ("exact", "plain", picks)]
    goals = {"packets": case.packets, "exact": case.exact, picks: case.picks}
    compared += [("corrected", other, goal) for other, goal in goals.items()]
    for name, other, goal in compared:
        ours, theirs = (ds.isel({"pass": -1}).sel(setting=n) for n in (name, other))
        for i, (metric, error) in enumerate((("nMSE", "nmse"), ("relMSE", "rel_mse"))):
            trial.figure(
                f"{case.name}: {name} vs {other}, {metric}·time",
                float(ours[error]),
                metric,
                baseline=float(theirs[error]),
                ratios=[gain(ds, name, other, error)],
                goal=goal[i] if goal else None,
                cpu_s=float(ours["cpu_s"]),
                other_cpu_s=float(theirs["cpu_s"]),
                passes=case.passes,
            )
    of = {name: ds.sel(setting=name) for name in settings}
    same = float(np.abs(of["packets"]["picture"] - of["exact"]["picture"]).max())
    trial.check(f"{case.name}: exact passes differ from those of packets", same, 0)
    found = (1 + of["corrected"]["energy"]) / (1 + of["packets"]["energy"]) - 1
    what = f"{case.name}: |t| of the energy of corrected passes"
    trial.check(what, abs(student_t(found)), LIMIT_Z)


def bias(trial: Trial, case: Case, scene: vc.Scene) -> None:
    """What many corrected passes have that exact ones of the same samples have not."""
    caches = {"correct": CORRECTED, "replace": PLAIN}
    light = vc.Whitted(n_vpls=case.n_vpls)
    both, mean = differences(scene, light, caches, case.many_size, case.many)
    found, plain = both["correct"], both["replace"]
    what = f"{case.name}: {case.many} corrected passes"
    trial.check(f"{what}, |z| of the energy", abs(energy_z(found)), LIMIT_MANY)
    squared, z = persistent_z(found, mean)
    trial.check(f"{what}, persistent squared error in standard errors", z, LIMIT_BIAS)
    of_plain, z_plain = persistent_z(plain, mean)
    trial.at_most(
        f"{case.name}: many passes, noise of the corrections of one pass",
        float(np.square(found).mean() / mean**2),
        "nMSE",
        None,
        persistent=squared,
        plain=of_plain,
        plain_z=z_plain,
        plain_energy_z=energy_z(plain),
        passes=case.many,
    )


def never_slower(trial: Trial, case: CannotWin, scene: vc.Scene) -> None:
    """CPU seconds of exact passes over those of corrected ones."""
    picture = partial(vc.Progressive, scene, case.light, size=case.size)
    picture(visibility=vc.Exact()).passes(1)  # builds the trees
    taken = []
    for _ in range(TURNS if case.goal else 1):
        ways = {
            "exact": picture(visibility=vc.Exact()),
            "ours": picture(visibility=vc.Aqvc(), use="correct"),
        }
        samples, frames = turns(
            {n: partial(way.passes, 1) for n, way in ways.items()}, case.passes, warm_up=False
        )
        taken.append([sum(s.cpu_s for s in samples[name]) for name in ways])
    frame = frames["ours"]
    trial.figure(
        f"never slower, {case.name}: corrected vs exact passes, CPU time",
        statistics.median(ours for _, ours in taken),
        "s",
        baseline=statistics.median(exact for exact, _ in taken),
        ratios=[exact / ours for exact, ours in taken],
        goal=case.goal,
        exact_queries=frame.counters["exact_queries"] / frame.counters["queries"],
        becomes_exact=any("exact visibility from" in text for text in frame.warnings),
        passes=case.passes,
    )

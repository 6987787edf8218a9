"""Lights for which corrections cannot win: passes then cost as much as exact ones."""

from __future__ import annotations

import statistics
from dataclasses import dataclass
from typing import Any

import viscache as vc
from viscache_lab.bench.errors import Run, take_turns
from viscache_lab.experiment import Trial

#: Exact CPU seconds over ours must be at least this: 3 % more.
GOAL = 1 / 1.03
#: Pictures of each way, one after the other: a ratio is that of a pair whose passes took turns.
TURNS = 5


@dataclass(frozen=True)
class Case:
    """A picture."""

    name: str
    scene: str
    light: vc.Direct | vc.Whitted
    size: tuple[int, int] = (160, 100)
    passes: int = 16
    goal: float | None = GOAL


def _alone(n: int) -> vc.Whitted:
    """N virtual lights and no samples of area lights or skies."""
    return vc.Whitted(n_vpls=n, n_area=0, n_environment=0, n_brdf=0)


CASES = (
    Case("24 lamps", "room?triangles=200000", vc.Direct(n_area=0)),
    Case("16 virtual lights", "garage", _alone(16)),
    Case("32 virtual lights", "church", _alone(32)),
    Case("own samples", "living-room/scene.xml", vc.Direct()),
    Case(
        "open sky",
        "courtyard",
        vc.Direct(n_area=0, environment="shared", n_environment=256, n_brdf=0),
    ),
    Case("light through a gap", "veach-ajar/scene.pbrt", vc.Whitted(n_vpls=256)),
)
QUICK = (Case("24 lamps", "room?triangles=3000", vc.Direct(n_area=0), (48, 32), 4, None),)


def never_slower(trial: Trial, cases: tuple[Case, ...]) -> None:
    """CPU seconds of exact passes over those of corrected ones."""
    for case, scene in trial.scenes(cases):
        _measure(trial, case, scene)


def _measure(trial: Trial, case: Case, scene: vc.Scene) -> None:
    def picture(visibility: Any, use: Any = None) -> vc.Progressive:
        return vc.Progressive(scene, case.light, visibility=visibility, use=use, size=case.size)

    picture(vc.Exact()).passes(1)  # builds the trees
    turns = []
    for _ in range(TURNS if case.goal else 1):
        exact, ours = Run(picture(vc.Exact())), Run(picture(vc.Aqvc(), "correct"))
        take_turns([exact, ours], case.passes)
        turns.append((exact.cpu_s, ours.cpu_s))
    frame = ours.picture.frame
    trial.figure(
        f"never slower, {case.name}: corrected vs exact passes, CPU time",
        statistics.median(cpu_s for _, cpu_s in turns),
        "s",
        baseline=statistics.median(cpu_s for cpu_s, _ in turns),
        ratios=[theirs / ours_s for theirs, ours_s in turns],
        goal=case.goal,
        exact_queries=frame.counters["exact_queries"] / frame.counters["queries"],
        becomes_exact=any("exact visibility from" in text for text in frame.warnings),
        passes=case.passes,
    )

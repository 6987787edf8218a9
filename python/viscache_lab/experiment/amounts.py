"""Fair timing: both sides take turns, and a figure is the median of the ratios."""

from __future__ import annotations

import math
import os
import platform
import statistics
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, Literal, TypeAlias, TypeVar

import numpy as np

import viscache as vc
from viscache.base.provenance import cpu_model, embree_version, isa
from viscache.scenes import build

Key = TypeVar("Key")
S = TypeVar("S", bound="Sample")
Clock: TypeAlias = Literal["cpu_s", "wall_s"]


@dataclass(frozen=True, kw_only=True, slots=True)
class Sample:
    """Duration of one run: wall-clock seconds and CPU seconds of all threads."""

    wall_s: float
    cpu_s: float


def timed(function: Callable[[], Any]) -> tuple[Sample, Any]:
    """Run a function once; CPU seconds count all threads of this process."""
    wall, cpu = time.perf_counter(), time.process_time()
    result = function()
    return Sample(wall_s=time.perf_counter() - wall, cpu_s=time.process_time() - cpu), result


def interleave(
    runs: Mapping[Key, Callable[[], S]], repeats: int, *, warm_up: bool = True
) -> dict[Key, list[S]]:
    """Let all runs take turns, `repeats` times; every other round is in reverse order."""
    names = list(runs)
    if warm_up:
        for name in names:
            runs[name]()
    samples: dict[Key, list[S]] = {name: [] for name in names}
    for i in range(repeats):
        for name in names if i % 2 == 0 else reversed(names):
            samples[name].append(runs[name]())
    return samples


def turns(
    runs: Mapping[Any, Callable[[], Any]],
    repeats: int,
    *,
    warm_up: bool = True,
    clock: Callable[[Any], Sample] | None = None,
) -> tuple[dict[Any, list[Sample]], dict[Any, Any]]:
    """Time runs that take turns, and keep their answers; one that gives a `Sample` is timed by it.

    `clock` is the duration of an answer, e.g. `frame_clock`; that of the call by default.
    """
    answers: dict[Any, Any] = {}

    def run(name: Any) -> Sample:
        time, answer = timed(runs[name])
        if isinstance(answer, Sample):
            return answer
        answers[name] = answer
        return time if clock is None else clock(answer)

    return interleave({n: partial(run, n) for n in runs}, repeats, warm_up=warm_up), answers


def frame_clock(frame: vc.Frame) -> Sample:
    """The duration of a frame by its own timings."""
    return Sample(wall_s=frame.timings["total_s"], cpu_s=frame.timings["cpu_s"])


def visibility_clock(frame: vc.Frame) -> Sample:
    """The time of a frame's visibility."""
    return Sample(wall_s=frame.timings["visibility_s"], cpu_s=frame.timings["visibility_cpu_s"])


def unbuilt_clock(frame: vc.Frame) -> Sample:
    """The duration of a frame without the build of its structures."""
    t = frame.timings
    return Sample(wall_s=t["total_s"] - t["build_s"], cpu_s=t["cpu_s"])


def fastest(runs: Mapping[Key, Callable[[], Any]]) -> Key:
    """Which run takes the least CPU time, of two turns."""
    samples, _ = turns(runs, 2, warm_up=False)
    return min(runs, key=lambda name: min(s.cpu_s for s in samples[name]))


def student_t(values: Any) -> float:
    """The mean of independent values over its standard error."""
    error = float(np.std(values, ddof=1)) / math.sqrt(len(values))
    return float(np.mean(values)) / max(error, 1e-300)


def figure(
    name: str,
    value: float,
    unit: str,
    *,
    baseline: float | None = None,
    ratios: list[float] | None = None,
    goal: float | None = None,
    **more: Any,
) -> dict[str, Any]:
    """One figure of a bench's JSON; `baseline` is the baseline's value in the same unit."""
    ratio = statistics.median(ratios) if ratios else None
    return {
        "name": name,
        "value": value,
        "unit": unit,
        "baseline": baseline,
        "ratio": ratio,
        "goal": goal,
        "holds": None if goal is None or ratio is None else bool(ratio >= goal),
        "low": min(ratios) if ratios else None,
        "high": max(ratios) if ratios else None,
        **more,
    }


def at_most_figure(
    name: str, value: float, unit: str, limit: float | None, **more: Any
) -> dict[str, Any]:
    """A figure that holds if its value is at most the limit; None: no limit."""
    made = figure(name, value, unit, **more)
    made["at_most"] = limit
    made["holds"] = None if limit is None else bool(value <= limit)
    return made


def ratio_figure(
    name: str,
    ours: Sequence[Sample],
    theirs: Sequence[Sample],
    *,
    clock: Clock = "cpu_s",
    work: float | None = None,
    goal: float | None = None,
    **more: Any,
) -> dict[str, Any]:
    """How many times faster viscache is than the baseline named in `name`.

    With `work` (rays, the same on both sides) values are millions per second, else seconds.
    `clock` determines the ratio; the other clock's ratio is recorded, too.
    """
    other: Clock = "wall_s" if clock == "cpu_s" else "cpu_s"

    def ratios(which: Clock) -> list[float]:
        pairs = zip(ours, theirs, strict=True)
        return [getattr(b, which) / getattr(a, which) for a, b in pairs]

    def value(samples: Sequence[Sample]) -> float:
        seconds = statistics.median(getattr(s, clock) for s in samples)
        return float(seconds if work is None else work / seconds / 1e6)

    more[f"ratio_{other.removesuffix('_s')}"] = statistics.median(ratios(other))
    return figure(
        name,
        value(ours),
        "s" if work is None else "Mray/s",
        baseline=value(theirs),
        ratios=ratios(clock),
        goal=goal,
        clock=clock.removesuffix("_s"),
        **more,
    )


def build_scene(spec: str) -> vc.Scene:
    """A built-in scene from its spec."""
    made = build(spec)
    return made if isinstance(made, vc.Scene) else vc.Scene.from_description(made, spec=spec)


def machine() -> dict[str, Any]:
    """The class of the machine that ran the bench, without names."""
    return {
        "processor": cpu_model(),
        "architecture": platform.machine(),
        "cores": len(os.sched_getaffinity(0)),
        "isa": isa()[0],
        "embree": embree_version(),
        "python": platform.python_version(),
        "system": platform.system(),
        "load": round(os.getloadavg()[0], 2),
    }

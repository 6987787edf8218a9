"""`viscache bench meter`: how often the intervals of audits hold the error, and what audits cost.

Coverage of whole pixels: frames are rendered once, then 500 seeds draw pixels by the code of frames
and estimate from them. Of queries: frames of 200 seeds, audited by a share of them and by all.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

import viscache as vc
from viscache.shot.audited import draw_audit_pixels, pixel_estimates
from viscache_lab.experiment import BENCHES, Trial

Array = npt.NDArray[np.float64]

#: The coverage of a 95 % interval that holds.
COVERAGE = (0.93, 0.98)
#: Over fewer seeds, of queries and of quick runs: so many standard errors below 95 %.
MOST_Z = 3.0
#: Share of a large frame's CPU seconds.
MOST_COST = 0.03


@dataclass(frozen=True, kw_only=True)
class Case:
    """A picture."""

    name: str
    scene: str
    integrator: vc.Direct | vc.Whitted
    cache: vc.Aqvc
    size: tuple[int, int] = (400, 250)
    seeds: int = 500
    pixels: tuple[int, ...] = (1024, 4096)


VPLS = vc.Whitted(n_vpls=1024, n_area=0, n_environment=0, n_brdf=0)
LAMPS = vc.Direct(n_area=0, n_environment=0, n_brdf=0)
ALL = vc.Aqvc(exact_groups=())
CASES = (
    Case(name="room", scene="room?triangles=200000", integrator=VPLS, cache=vc.Aqvc()),
    Case(name="room, lamps", scene="room?triangles=200000", integrator=LAMPS, cache=ALL),
    Case(name="apartment", scene="apartment", integrator=VPLS, cache=vc.Aqvc()),
    Case(name="apartment, lamps", scene="apartment", integrator=LAMPS, cache=ALL),
    Case(name="conference", scene="conference", integrator=VPLS, cache=vc.Aqvc()),
    Case(name="living-room", scene="living-room/scene.xml", integrator=VPLS, cache=vc.Aqvc()),
    Case(name="sponza", scene="sponza-dabrovic/scene.xml", integrator=VPLS, cache=vc.Aqvc()),
)
QUICK = (
    Case(
        name="room, 128²",
        scene="room?triangles=3000",
        integrator=vc.Whitted(n_vpls=64, n_area=0, n_environment=0, n_brdf=0),
        cache=vc.Aqvc(exact_groups=()),
        size=(128, 128),
        seeds=200,
        pixels=(1024,),
    ),
)
#: The scene whose queries are audited.
BY_QUERIES = "room?triangles=3000"
#: Frames whose cost is measured: 1024² pixels with 1024 virtual lights.
LARGE = ("room", "apartment", "conference")
LARGE_SIZE = (1024, 1024)


@BENCHES.add(
    "meter",
    "audits of cached frames: coverage of their intervals, and their cost",
    cases=(*CASES, BY_QUERIES),
    quick_cases=(*QUICK, BY_QUERIES),
    note="Values of coverage: share of seeds whose 95 % interval holds the true error. half_width:"
    " median of the upper end over the value, less 1. Coverage of nrmse: of the interval that"
    " frames do not show, ±1.96 standard errors.",
)
def meter(trial: Trial, case: Case | str, scene: vc.Scene) -> None:
    """Coverage of the intervals, and the cost of audits."""
    if isinstance(case, str):
        queries(trial, scene, seeds=40 if trial.quick else 200)
        return
    pixels(trial, case, scene)
    if trial.quick:
        cost(trial, case, scene, case.size, None)
    elif case.name in LARGE:
        cost(trial, case, scene, LARGE_SIZE, MOST_COST)


def pixels(trial: Trial, case: Case, scene: vc.Scene) -> None:
    """Coverage of the intervals from whole pixels, of the frame and of its light groups."""
    exact = vc.render(scene, case.integrator, size=case.size)
    cached = vc.render(scene, case.integrator, visibility=case.cache, size=case.size)
    bare = vc.render(scene, case.integrator, visibility=vc.Unoccluded(), size=case.size)
    # As in frames: the light of groups that may be wrong, without shadows
    wrong = [n for n in cached.counters["groups"] if (cached.layers[n] != exact.layers[n]).any()]
    unoccluded = sum(bare.layers[name].sum(axis=2) for name in wrong)
    for layer in ("color", *cached.counters["groups"]):
        error, light, truth = _error(cached, exact, layer)
        if not truth["rel_l1"]:
            continue
        for n in case.pixels:
            found = _coverage(case, unoccluded, error, light, truth, n)
            name = f"{case.name}, {layer}, {n} pixels: coverage of rel_l1"
            shown = {**found, "true": truth["rel_l1"]}
            coverage = found["coverage"]
            trial.figure(name, coverage, "", ratios=[coverage], goal=COVERAGE[0], **shown)
            if layer == "color":
                limits = COVERAGE if case.seeds >= 500 else _coverage_of_few(case.seeds)
                _check(trial, name, found["coverage"], limits)


def _error(cached: vc.Frame, exact: vc.Frame, layer: str) -> tuple[Array, float, dict[str, float]]:
    """The error of each pixel, the light of the cached layer, and the true rel_l1 and nrmse."""
    a, b = (f.layers[layer].astype(np.float64) for f in (cached, exact))
    light = float(b.sum())
    truth = {"rel_l1": 0.0, "nrmse": 0.0}
    if light > 0:
        rms = float(np.sqrt(np.square(a - b).mean()))
        truth = {"rel_l1": float(np.abs(a - b).sum()) / light, "nrmse": rms / float(b.mean())}
    return a - b, float(a.sum()), truth


def _coverage(
    case: Case, unoccluded: Any, error: Array, light: float, truth: dict[str, float], n: int
) -> dict[str, Any]:
    """Shares of the seeds whose interval holds the truth."""
    held, shown, of_nrmse, widths = 0, 0, 0, []
    for seed in range(case.seeds):
        drawn = draw_audit_pixels(unoccluded, n, seed)
        x, y = drawn[:, :2].astype(int).T
        found = pixel_estimates(drawn[:, 2], error[y, x], unoccluded.size, light)
        rel_l1, nrmse = found["rel_l1"], found["nrmse"]
        spread = 1.96 * nrmse["se"] / max(nrmse["value"], 1e-30)
        of_nrmse += abs(np.log(max(nrmse["value"], 1e-30) / truth["nrmse"])) <= spread
        if rel_l1["low"] is None:
            continue
        shown += 1
        held += rel_l1["low"] <= truth["rel_l1"] <= rel_l1["high"]
        widths.append(rel_l1["high"] / rel_l1["value"] - 1)
    return {
        "coverage": held / shown if shown else float("nan"),
        "shown": shown / case.seeds,
        "half_width": float(np.median(widths)) if widths else None,
        "coverage_of_nrmse": of_nrmse / case.seeds,
    }


def queries(trial: Trial, scene: vc.Scene, seeds: int) -> None:
    """Coverage of the bias and of the share of wrong answers."""
    lights = vc.Whitted(n_vpls=64, n_area=0, n_environment=0, n_brdf=0)
    shot = vc.Shot(scene, lights, visibility=ALL, size=(96, 64))
    for share in (0.01, 0.05):
        held, shown = {"bias": 0, "wrong": 0}, {"bias": 0, "wrong": 0}
        for seed in range(seeds):
            one, all_ = (
                shot.with_(seed=seed).render(audit=vc.AuditQueries(share=s)).audit
                for s in (share, 1.0)
            )
            for name in held:
                found, truth = getattr(one, name), getattr(all_, name).value
                shown[name] += found.low is not None
                held[name] += found.low is not None and found.low <= truth <= found.high
        for name in held:
            what = f"room, 96×64, {share:.0%} of the queries: coverage of {name}"
            value = held[name] / max(1, shown[name])
            trial.figure(what, value, "", shown=shown[name] / seeds)
            _check(trial, what, value, _coverage_of_few(seeds))


def cost(
    trial: Trial, case: Case, scene: vc.Scene, size: tuple[int, int], limit: float | None
) -> None:
    """CPU seconds of audits over those of the frame without them, in one frame."""
    for audit in (vc.AuditPixels(), vc.AuditQueries()):
        frame = vc.render(scene, case.integrator, visibility=case.cache, size=size, audit=audit)
        spent = frame.timings["audit_cpu_s"]
        share = spent / (frame.timings["cpu_s"] - spent)
        of_pixels = isinstance(audit, vc.AuditPixels)
        what = "1024 pixels" if of_pixels else "1 % of the queries"
        trial.at_most(
            f"{case.name}, {size[0]}×{size[1]}: cost of an audit of {what}",
            share,
            "of the frame",
            limit if of_pixels else None,
            seconds=spent,
            frame_seconds=frame.timings["cpu_s"],
            rays=frame.counters["audit"]["rays"],
        )


def _coverage_of_few(seeds: int) -> tuple[float, float]:
    """What 95 % may look like over few seeds."""
    return 0.95 - MOST_Z * float(np.sqrt(0.95 * 0.05 / seeds)), 1.0


def _check(trial: Trial, what: str, value: float, limits: tuple[float, float]) -> None:
    trial.check(f"{what}, at least {limits[0]}", limits[0] - value, 0.0)
    trial.check(f"{what}, at most {limits[1]}", value, limits[1])

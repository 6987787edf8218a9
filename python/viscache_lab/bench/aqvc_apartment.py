"""`viscache bench aqvc-apartment`: lights of every kind, also with separate samples per pixel."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, Literal

import viscache as vc
from viscache.metrics import compare
from viscache.settings.visibility import Visibility
from viscache_lab.bench.aqvc_frame import STAGES
from viscache_lab.experiment import BENCHES, Trial
from viscache_lab.experiment.amounts import turns, unbuilt_clock, visibility_clock

GOAL = 6.0
REL_L1_GOAL = 0.015
#: A frame with a larger error than this is wrong, however fast it is.
WRONG_REL_L1 = 0.2
Sky = Literal["mis", "shared"]
SKIES: tuple[Sky, ...] = ("mis", "shared")


def settings(c_e: float) -> dict[str, Visibility]:
    """The visibilities compared; the first has the goal."""
    cached = vc.Aqvc(c_e=c_e, c_e_groups={"point": 4.0}, exact_groups=())
    return {
        "rows": cached,
        "light's cells": replace(cached, paper=vc.PaperForm(cell_density="light")),
        "default": replace(cached, exact_groups="auto"),
        "exact": vc.Exact(),
    }


@BENCHES.add(
    "aqvc-apartment",
    "24 lamps, 1024 virtual lights and 256 sky samples with the quantized cache",
    cases=("apartment?triangles=750000",),
    quick_cases=("apartment?triangles=20000",),
    note="exact: our fastest exact order. Each pixel's own samples: 128 by radiance and 128 by the"
    " BRDF; shared: 256 directions. C_E 10, of lamps 4. Ratios are of CPU seconds of whole"
    " frames, one run each.",
)
def aqvc_apartment(trial: Trial, _: str, scene: vc.Scene) -> None:
    """24 lamps, 1024 virtual lights and 256 sky samples, per pixel or shared by all pixels."""
    scene.caster()  # not part of any frame
    for sky in SKIES:
        measure(trial, scene, sky)
    if not trial.quick:
        measure_table(trial, scene)


def integrator(sky: Sky, quick: bool, **more: Any) -> vc.Whitted:
    """The paper's numbers of samples; an eighth of them if quick."""
    share = 8 if quick else 1
    each = 128 // share if sky == "mis" else 256 // share
    return vc.Whitted(
        **({"n_vpls": 1024 // share} | more),
        n_area=0,
        n_environment=each,
        n_brdf=each if sky == "mis" else 0,
        environment=sky,
    )


def measure(trial: Trial, scene: vc.Scene, sky: Sky) -> None:
    """Compare whole frames with exact ones."""
    size = (160, 100) if trial.quick else (1280, 800)
    shot = vc.Shot(scene, integrator(sky, trial.quick), size=size)
    runs = {key: shot.with_(visibility=by).render for key, by in settings(10.0).items()}
    if sky == "shared":
        del runs["light's cells"], runs["default"]
    samples, frames = turns(runs, 1, warm_up=False, clock=unbuilt_clock)
    name = "own sky samples" if sky == "mis" else "shared sky"
    for key in runs:
        if key == "exact":
            continue
        groups = ("point", "vpl", "environment")
        errors = {group: _rel_l1(frames[key], frames["exact"], group) for group in groups}
        error = compare(frames[key], frames["exact"]).rel_l1 or 0.0
        goal = GOAL if key == "rows" and sky == "mis" and not trial.quick else None
        row = trial.ratio(
            f"apartment, {name}, {key} whole-frame vs exact",
            samples[key],
            samples["exact"],
            goal=goal,
            rel_l1=error,
            rel_l1_groups=errors,
            stages_cpu_s={s: frames[key].timings[f"{s}_cpu_s"] for s in STAGES},
            exact_stages_cpu_s={s: frames["exact"].timings[f"{s}_cpu_s"] for s in STAGES},
            share_rays=ray_shares(frames[key]),
        )
        if goal is not None:
            row |= {"rel_l1_goal": REL_L1_GOAL, "rel_l1_holds": error <= REL_L1_GOAL}
        trial.check(f"{row['name']}: rel_l1", error, WRONG_REL_L1)


def measure_table(trial: Trial, scene: vc.Scene) -> None:
    """Visibility of the sky samples alone: bit rows, the hash table and rays."""
    shot = vc.Shot(scene, integrator("mis", False, n_vpls=0), size=(1280, 800))
    ways: dict[str, Visibility] = {
        "rows": vc.Aqvc(c_e=10, exact_groups=()),
        "table": vc.Aqvc(c_e=10, paper=vc.PaperForm(form="pairs")),
        "exact": vc.Exact(),
    }
    frames = {key: shot.with_(visibility=by).render() for key, by in ways.items()}
    queries = frames["exact"].counters["queries"]
    took = {key: visibility_clock(frame) for key, frame in frames.items()}
    for key in ("rows", "table"):
        trial.ratio(
            f"apartment, lamps and own sky samples, {key}: visibility vs exact",
            [took[key]],
            [took["exact"]],
            nanoseconds_per_query=took[key].cpu_s / queries * 1e9,
            share_rays=ray_shares(frames[key]),
            rel_l1=_rel_l1(frames[key], frames["exact"], "environment"),
        )


def ray_shares(frame: vc.Frame) -> dict[str, float]:
    """Rays per query, by light group."""
    groups = frame.counters["groups"]
    return {n: g["rays"] / g["queries"] for n, g in groups.items() if g["queries"]}


def _rel_l1(frame: vc.Frame, exact: vc.Frame, layer: str) -> float:
    a, b = frame.layers[layer].astype(float), exact.layers[layer].astype(float)
    return float(abs(a - b).sum() / max(b.sum(), 1e-300))

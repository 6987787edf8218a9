"""`viscache bench aqvc-lookup`: what a query costs in each form of the cache, beside a ray."""

from __future__ import annotations

from collections.abc import Callable

from viscache.bench.common import Outcome, Sample, build_scene, figure, interleave
from viscache.frame import Frame
from viscache.integrators import Whitted
from viscache.metrics import compare
from viscache.render import render
from viscache.visibility import Aqvc, Exact, Visibility

__all__ = ["aqvc_lookup"]


def aqvc_lookup(quick: bool = False) -> Outcome:
    """Time inside the oracle per query: tracing of misses included, and with nearly none."""
    outcome = Outcome()
    scene = build_scene("room?triangles=20000" if quick else "room?triangles=200000")
    size = (96, 96) if quick else (512, 512)
    integrator = Whitted(n_vpls=64 if quick else 256)
    settings: dict[str, Visibility] = {"ray": Exact()}
    for form in ("waves", "rows", "pairs"):
        settings[form] = Aqvc(c_e=10, refinement="on", form=form)
        # Cells so large that nearly every query is answered by a look-up
        settings[f"{form}, look-ups alone"] = Aqvc(c_e=200, refinement="off", form=form)
    frames: dict[str, Frame] = {}

    def runner(key: str) -> Callable[[], Sample]:
        def run() -> Sample:
            frames[key] = render(scene, integrator, visibility=settings[key], size=size)
            t = frames[key].timings
            return Sample(wall_s=t["visibility_s"], cpu_s=t["visibility_cpu_s"])

        return run

    scene.caster()
    samples = interleave({k: runner(k) for k in settings}, 2 if quick else 3, warm_up=False)
    exact = frames["ray"]
    per_query = {
        key: [s.cpu_s / max(1, frames[key].counters["queries"]) * 1e9 for s in samples[key]]
        for key in settings
    }
    for key in settings:
        if key == "ray":
            continue
        ratios = [a / b for a, b in zip(per_query["ray"], per_query[key], strict=True)]
        error = compare(frames[key], exact).rel_l1 or 0.0
        outcome.figures.append(
            figure(
                f"{key} ns/query vs ns/ray",
                sorted(per_query[key])[len(ratios) // 2],
                "ns",
                baseline=sorted(per_query["ray"])[len(ratios) // 2],
                ratios=ratios,
                rel_l1=error,
                share_rays=frames[key].counters["rays"] / max(1, frames[key].counters["queries"]),
                clock="cpu",
            )
        )
        same = frames[key].counters["queries"] == exact.counters["queries"]
        outcome.check(f"{key}: other queries than exact", float(not same), 0)
        if "alone" not in key:
            outcome.check(f"{key}: rel_l1", error, 0.1)
    return outcome

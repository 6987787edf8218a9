"""`viscache bench tune`: the error that frames have at the settings that `vc.tune` chose.

The scenes were not used to design the search.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import viscache as vc
from viscache.metrics import compare
from viscache_lab.experiment import BENCHES, Trial

#: The error may exceed the target, and lie below it, by this factor.
WITHIN = 1.3
#: The error may differ so much from that of the pixels that checked it.
FORETOLD = 0.5


@dataclass(frozen=True, kw_only=True)
class Case:
    """A picture and its target. A scene is a spec, or a folder of $VISCACHE_SCENES and a file."""

    name: str
    scene: str
    rel_l1: float = 0.02
    n_vpls: int = 256
    size: tuple[int, int] = (256, 160)


CASES = (
    Case(name="garage", scene="garage"),
    Case(name="church", scene="church"),
    Case(name="classroom_like", scene="classroom_like"),
    Case(name="courtyard", scene="courtyard?triangles=200000"),
    Case(name="living-room", scene="living-room/scene.xml"),
    Case(name="sponza-dabrovic", scene="sponza-dabrovic/scene.xml"),
    Case(name="classroom", scene="classroom/scene.xml"),
    Case(name="sanmiguel-part", scene="sanmiguel-part/scene.xml"),
    Case(name="veach-ajar", scene="veach-ajar/scene.pbrt"),
)
QUICK = (Case(name="church", scene="church?triangles=4000", rel_l1=0.04, n_vpls=32, size=(96, 60)),)


@BENCHES.add(
    "tune",
    "errors of whole frames at the settings that vc.tune chose, on nine scenes",
    cases=CASES,
    quick_cases=QUICK,
    note="Values: error of the whole frame over the target; at most 1.3 holds. low, high: the"
    " interval that tune gave, on pixels that no pilot saw. rays_saved: rays of C_E alone at"
    " its own error over rays of the three parameters. speedup: CPU seconds of the exact frame"
    " over those of this one.",
)
def tune_scenes(trial: Trial, case: Case, scene: vc.Scene) -> None:
    """Tune three parameters and one, then render whole frames."""
    light = vc.Whitted(n_vpls=case.n_vpls)
    given: dict[str, Any] = {"size": case.size, "threads": 1}
    found = vc.tune(scene, light, rel_l1_reflected=case.rel_l1, **given)
    alone = vc.tune(scene, light, rel_l1_reflected=case.rel_l1, parameter="c_e", **given)
    exact = vc.render(scene, light, **given)
    frames = {
        name: vc.render(scene, light, visibility=one.visibility, **given)
        for name, one in (("found", found), ("alone", alone))
    }
    error, of_alone = (
        compare(frame, exact, metrics=["rel_l1_reflected"])["rel_l1_reflected"]
        for frame in frames.values()
    )
    assert error is not None
    trial.check(
        f"{case.name}: error of the frame against the foretold one, relative",
        abs(error / max(found.error, 1e-12) - 1),
        FORETOLD,
    )
    settings = ", ".join(f"{n} {v:.3g}" for n, v in {"c_e": found.value, **found.also}.items())
    rays = {name: frame.counters["rays"] for name, frame in frames.items()}
    trial.at_most(
        f"{case.name}: rel_l1_reflected of the frame over the target {case.rel_l1:g}",
        error / case.rel_l1,
        "×",
        WITHIN,
        settings=settings,
        target=case.rel_l1,
        error=error,
        foretold=found.error,
        interval=list(found.interval),
        outcome=found.outcome,
        message=found.message,
        queries_per_ray=exact.counters["queries"] / max(1, rays["found"]),
        speedup=exact.timings["cpu_s"] / frames["found"].timings["cpu_s"],
        alone_c_e=alone.value,
        alone_error=of_alone,
        rays_saved=rays["alone"] / max(1, rays["found"]),
        pilots=len(found.pilots),
    )
    trial.figure(
        f"{case.name}: CPU seconds of the frame vs exact",
        frames["found"].timings["cpu_s"],
        "s",
        baseline=exact.timings["cpu_s"],
        ratios=[exact.timings["cpu_s"] / frames["found"].timings["cpu_s"]],
    )

"""`viscache bench shafts`: exact visibility of shared lights by shafts and by packets of rays."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Any, Literal

import viscache as vc
from viscache.shot.render import render_part
from viscache.shot.shot import BareShot
from viscache_lab.experiment import BENCHES, Trial
from viscache_lab.experiment.amounts import turns, visibility_clock

Engine = Literal["packets", "shafts", "auto"]
ENGINES: tuple[Engine, ...] = ("packets", "shafts", "auto")
#: Embree's coherent traversal changes one answer in 10⁹ by rounding; shafts have those of the
#: other one.
MOST_CHANGED = 1e-4


@dataclass(frozen=True)
class Case:
    """Every `parts`-th tile of a frame with virtual point lights."""

    name: str
    scene: str
    size: tuple[int, int]
    spp: int
    n_vpls: int
    parts: int
    goal: float | None = None


CASES = (
    Case("room, 512², 16 samples", "room?triangles=200000", (512, 512), 16, 256, 27, 2.9),
    Case("room, 1024²", "room?triangles=200000", (1024, 1024), 1, 1024, 7, 1.9),
    Case("room, 640×400", "room?triangles=200000", (640, 400), 1, 1024, 3, 1.15),
    Case("apartment, 640×400", "apartment", (640, 400), 1, 1024, 3, 1.25),
    Case("sponza, 640×400", "sponza-dabrovic/scene.xml", (640, 400), 1, 1024, 3, 1.8),
    Case("living-room, 640×400", "living-room/scene.xml", (640, 400), 1, 1024, 3, 1.25),
)
QUICK = (Case("room, 64², 4 samples", "room?triangles=3000", (64, 64), 4, 70, 1),)


@BENCHES.add(
    "shafts",
    "exact visibility of virtual point lights by shafts against packets of rays",
    cases=CASES,
    quick_cases=QUICK,
    note="Visibility of some tiles, one thread, with all preparation but the tree of the scene;"
    " packets by light with the coherent flag. open: share of queries that rays answer.",
)
def shafts(trial: Trial, case: Case, scene: vc.Scene) -> None:
    """CPU seconds of visibility in some tiles, one thread; frames must have equal bytes."""
    scene.caster()
    runs = {e: partial(_frame, case, scene, e, coherent=True) for e in ENGINES}
    samples, frames = turns(runs, trial.repeats(3), clock=visibility_clock)
    packets, incoherent = frames["packets"], _frame(case, scene, "packets", coherent=False)
    queries = packets.counters["queries"]
    for engine in ENGINES[1:]:
        frame = frames[engine]
        work = frame.parameters["engine"]
        asked = max(1, work["shaft_queries"])
        trial.ratio(
            f"{case.name}: {engine} vs packets",
            samples[engine],
            samples["packets"],
            goal=case.goal if engine == "shafts" else None,
            nanoseconds_per_query=1e9 * min(s.cpu_s for s in samples[engine]) / queries,
            packets_nanoseconds=1e9 * min(s.cpu_s for s in samples["packets"]) / queries,
            by_shafts=work["shaft_queries"] / queries,
            open=(work["shaft_doubted"] + work["shaft_long_lists"]) / asked,
            counted=work,
        )
        differ = float(frame.sha256 != incoherent.sha256)
        trial.check(f"{case.name}: {engine}, frames with other bytes", differ, 0)
    changed = float((packets.image != incoherent.image).any(axis=-1).mean())
    trial.check(f"{case.name}: share of pixels that Embree's flag changes", changed, MOST_CHANGED)


def _frame(case: Case, scene: vc.Scene, engine: Engine, *, coherent: bool) -> vc.Frame:
    exact = vc.Exact(engine=engine, order="by_light", coherent=coherent)
    more: dict[str, Any] = {"size": case.size, "spp": case.spp, "threads": 1}
    part = (min(3, case.parts - 1), case.parts)
    shot = BareShot(scene, vc.Whitted(n_vpls=case.n_vpls), visibility=exact, **more)
    return render_part(shot, part)

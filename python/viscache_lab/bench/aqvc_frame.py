"""`viscache bench aqvc-frame`: frames with the quantized cache against exact frames."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import viscache as vc
from viscache.metrics import compare
from viscache.settings.visibility import Visibility
from viscache_lab.experiment import BENCHES, Trial
from viscache_lab.experiment.amounts import Sample, turns, unbuilt_clock

ROOM = "room?triangles=200000"
STAGES = ("eye_paths", "contributions", "visibility", "shading")
#: A frame with a larger error than this is wrong, however fast it is.
WRONG_REL_L1 = 0.1
#: A goal applies only up to this error.
REL_L1_GOAL = 0.01


@dataclass(frozen=True, kw_only=True, slots=True)
class Case:
    """One frame at C_E `c_e`, and at `tuned`, the setting that came nearest to the goal."""

    scene: str = ROOM
    size: tuple[int, int]
    spp: int = 1
    n_vpls: int = 1024
    c_e: float = 10
    tuned: vc.Aqvc | None = None
    goal: float | None = None
    repeats: int = 3
    with_slow: bool = False

    @property
    def name(self) -> str:
        """As in the figures' names."""
        scene = self.scene.partition("?")[0].partition("/")[0]
        lights = f" {self.n_vpls} VPLs" if self.n_vpls else " lamps alone"
        return f"{scene} {self.size[0]}x{self.size[1]}x{self.spp}{lights}"


CASES = (
    Case(size=(1024, 1024), goal=5, with_slow=True, tuned=vc.Aqvc(preset="fast", c_e=12)),
    Case(
        size=(512, 512),
        spp=16,
        n_vpls=256,
        c_e=24,
        goal=10,
        with_slow=True,
        tuned=vc.Aqvc(preset="fast", c_e=24, c_e_groups={"point": 8.0}),
    ),
    Case(size=(512, 512), spp=4, c_e=20),
    Case(
        size=(512, 512),
        spp=16,
        n_vpls=0,
        c_e=16,
        goal=4,
        tuned=vc.Aqvc(c_e=16, c_n=2, c_z=2.0, c_r=2.0),
    ),
    Case(size=(1280, 800)),
    # Scenes that viscache does not include; they have no goal
    Case(scene="living-room/scene.xml", size=(640, 400)),
    Case(scene="veach-ajar/scene.pbrt", size=(640, 400)),
)
SMALL = "room?triangles=20000"
QUICK = (Case(scene=SMALL, size=(128, 128), n_vpls=64, repeats=2, with_slow=True),)
#: Words before a figure's name, its way, the baseline, and whether it has the case's goal.
FIGURES = (
    ("tuned, ", "tuned", "packets", True),
    ("tuned, ", "tuned", "exact", False),
    ("", "aqvc", "exact", False),
    ("", "aqvc", "packets", False),
    ("", "aqvc", "exact-by-pixel", False),
    ("point lights at C_E 2, ", "points", "exact", False),
    ("point lights at C_E 2, ", "points", "packets", False),
    ("hash ", "hash", "packets", False),
    ("exact, ", "exact", "packets", False),
)


@BENCHES.add(
    "aqvc-frame",
    "whole frames with the quantized cache against exact frames",
    cases=CASES,
    quick_cases=QUICK,
    note="packets: our fastest exact rays (16 neighbouring eye points towards one light); exact:"
    " vc.Exact(), which takes shafts where they pay; exact-by-pixel: 16 lights from one eye"
    " point; hash: the paper's form, one table look-up per query. Ratios are of CPU seconds of"
    " whole frames: camera paths, VPLs, keys, rays, shading; ratio_after_first_hits leaves"
    " camera paths out. tuned: the setting nearest the goal at rel_l1 <= 1 %, found by trial on"
    " this scene.",
)
def aqvc_frame(trial: Trial, case: Case, scene: vc.Scene) -> None:
    """The room in several sizes, with refinement for all light groups."""
    settings: dict[str, Visibility] = {"tuned": case.tuned} if case.tuned else {}
    settings |= {
        "aqvc": vc.Aqvc(c_e=case.c_e, refinement="on"),
        "points": vc.Aqvc(c_e=case.c_e, refinement="on", c_e_groups={"point": 2.0}),
        "packets": vc.Exact(engine="packets"),
        "exact": vc.Exact(),
    }
    # Slow, and far from any goal: runs once
    once: dict[str, Visibility] = {}
    if case.with_slow:
        once["exact-by-pixel"] = vc.Exact(order="by_pixel", engine="packets")
        once["hash"] = vc.Aqvc(c_e=case.c_e, refinement="on", paper=vc.PaperForm(form="pairs"))
    light = vc.Whitted(n_vpls=case.n_vpls) if case.n_vpls else vc.Direct()
    shot = vc.Shot(scene, light, size=case.size, spp=case.spp)
    scene.caster()  # not part of any frame
    samples: dict[str, list[Sample]] = {}
    frames: dict[str, vc.Frame] = {}
    for some, repeats in ((settings, case.repeats), (once, 1)):
        runs = {key: shot.with_(visibility=by).render for key, by in some.items()}
        taken, made = turns(runs, repeats, warm_up=False, clock=unbuilt_clock)
        samples |= taken
        frames |= made
    for prefix, key, base, has_goal in FIGURES:
        if key not in samples or base not in samples:
            continue
        pairs = min(len(samples[key]), len(samples[base]))
        error = compare(frames[key], frames["exact"]).rel_l1 or 0.0
        row = trial.ratio(
            f"{prefix}{case.name} whole-frame vs {base}",
            samples[key][:pairs],
            samples[base][:pairs],
            goal=case.goal if has_goal else None,
            rel_l1=error,
            ratio_after_first_hits=_after_first_hits(frames[base]) / _after_first_hits(frames[key]),
            **_shares(frames[key]),
        )
        if row["goal"] is not None:
            row |= {"rel_l1_goal": REL_L1_GOAL, "rel_l1_holds": error <= REL_L1_GOAL}
        trial.check(f"{row['name']}: rel_l1", error, WRONG_REL_L1)
    for key in ("packets", "exact-by-pixel"):
        if key in frames:
            unlike = float(frames[key].sha256 != frames["exact"].sha256)
            trial.check(f"{case.name}: bytes of exact and {key} differ", unlike, 0)


def _after_first_hits(frame: vc.Frame) -> float:
    """CPU seconds of a frame, without its camera paths."""
    return float(frame.timings["cpu_s"] - frame.timings["eye_paths_cpu_s"])


def _shares(frame: vc.Frame) -> dict[str, Any]:
    c = frame.counters
    queries = max(1, c["queries"])
    return {
        "share_occluded": c["occluded"] / queries,
        "share_boundary": c["boundary_queries"] / queries,
        "share_rays": c["rays"] / queries,
        "stages_cpu_s": {s: frame.timings[f"{s}_cpu_s"] for s in STAGES},
    }

"""`viscache bench aqvc-frame`: frames with the quantized cache against exact frames."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import viscache as vc
from viscache.metrics import compare
from viscache.scenes.sources import scene_file
from viscache.settings.visibility import Visibility
from viscache_lab.experiment import BENCHES, Trial
from viscache_lab.experiment.amounts import Sample, build_scene, ratio_figure, turns

ROOM = "room?triangles=200000"
SMALL = "room?triangles=20000"
#: A frame with a larger error than this is wrong, however fast it is.
WRONG_REL_L1 = 0.1


@dataclass(frozen=True, kw_only=True, slots=True)
class Case:
    """One frame at C_E `c_e`, and at `tuned`, the setting that came nearest to the goal."""

    size: tuple[int, int]
    spp: int
    n_vpls: int
    c_e: float
    tuned: vc.Aqvc | None = None
    goal: float | None = None
    repeats: int = 3
    with_slow: bool = False

    @property
    def label(self) -> str:
        """As in the figures' names."""
        lights = f" {self.n_vpls} VPLs" if self.n_vpls else " lamps alone"
        return f"{self.size[0]}x{self.size[1]}x{self.spp}{lights}"


CASES = (
    Case(
        size=(1024, 1024),
        spp=1,
        n_vpls=1024,
        c_e=10,
        goal=5,
        with_slow=True,
        tuned=vc.Aqvc(preset="fast", c_e=12),
    ),
    Case(
        size=(512, 512),
        spp=16,
        n_vpls=256,
        c_e=24,
        goal=10,
        with_slow=True,
        tuned=vc.Aqvc(preset="fast", c_e=24, c_e_groups={"point": 8.0}),
    ),
    Case(size=(512, 512), spp=4, n_vpls=1024, c_e=20),
    Case(
        size=(512, 512),
        spp=16,
        n_vpls=0,
        c_e=16,
        goal=4,
        tuned=vc.Aqvc(c_e=16, c_n=2, c_z=2.0, c_r=2.0),
    ),
    Case(size=(1280, 800), spp=1, n_vpls=1024, c_e=10),
)
QUICK = (Case(size=(128, 128), spp=1, n_vpls=64, c_e=10, repeats=2, with_slow=True),)
#: Scenes that viscache does not include; they have no goal.
FILES = ("living-room", "veach-ajar")
#: A goal applies only up to this error.
REL_L1_GOAL = 0.01


@BENCHES.add("aqvc-frame", "whole frames with the quantized cache against exact frames")
def aqvc_frame(trial: Trial) -> None:
    """The room in several sizes, with refinement for all light groups."""
    scene = build_scene(SMALL if trial.quick else ROOM)
    for case in QUICK if trial.quick else CASES:
        measure(trial, scene, "room", case)
    for name in () if trial.quick else FILES:
        path = scene_file(name)
        if path is None:
            trial.skip(name, "no scene file; VISCACHE_SCENES names the folder of scene folders")
        else:
            case = Case(size=(640, 400), spp=1, n_vpls=1024, c_e=10)
            measure(trial, vc.load_scene(path), name, case)
    trial.notes.append(
        "packets: our fastest exact rays (16 neighbouring eye points towards one light); exact:"
        " vc.Exact(), which takes shafts where they pay; exact-by-pixel: 16 lights from one eye"
        " point; hash: the paper's form, one table look-up per query. Ratios are of CPU seconds of"
        " whole frames: camera paths, VPLs, keys, rays, shading; ratio_after_first_hits leaves"
        " camera paths out. tuned: the setting nearest the goal at rel_l1 <= 1 %, found by trial on"
        " this scene."
    )


def measure(
    trial: Trial, scene: vc.Scene, name: str, case: Case, camera: str | None = None
) -> dict[str, vc.Frame]:
    """Add the figures of one case."""
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
    shot = vc.Shot(scene, light, size=case.size, spp=case.spp, camera=camera)
    scene.caster()  # not part of any frame
    samples: dict[str, list[Sample]] = {}
    frames: dict[str, vc.Frame] = {}
    for some, repeats in ((settings, case.repeats), (once, 1)):
        runs = {key: shot.with_(visibility=by).render for key, by in some.items()}
        found = turns(runs, repeats, warm_up=False, clock=without_build)
        samples |= found.samples
        frames |= found.answers
    figures = (
        ("tuned, ", "tuned", "packets", case.goal),
        ("tuned, ", "tuned", "exact", None),
        ("", "aqvc", "exact", None),
        ("", "aqvc", "packets", None),
        ("", "aqvc", "exact-by-pixel", None),
        ("point lights at C_E 2, ", "points", "exact", None),
        ("point lights at C_E 2, ", "points", "packets", None),
        ("hash ", "hash", "packets", None),
        ("exact, ", "exact", "packets", None),
    )
    for prefix, key, base, goal in figures:
        if key not in samples or base not in samples:
            continue
        pairs = min(len(samples[key]), len(samples[base]))
        error = compare(frames[key], frames["exact"]).rel_l1 or 0.0
        row = ratio_figure(
            f"{prefix}{name} {case.label} whole-frame vs {base}",
            samples[key][:pairs],
            samples[base][:pairs],
            goal=goal,
            rel_l1=error,
            ratio_after_first_hits=_after_first_hits(frames[base]) / _after_first_hits(frames[key]),
            **_shares(frames[key]),
        )
        if goal is not None:
            row |= {"rel_l1_goal": REL_L1_GOAL, "rel_l1_holds": error <= REL_L1_GOAL}
        trial.figures.append(row)
        trial.check(f"{row['name']}: rel_l1", error, WRONG_REL_L1)
    for key in ("packets", "exact-by-pixel"):
        if key in frames:
            unlike = float(frames[key].sha256 != frames["exact"].sha256)
            trial.check(f"{name} {case.label}: bytes of exact and {key} differ", unlike, 0)
    return frames


def without_build(frame: vc.Frame) -> Sample:
    """The duration of a frame without the build of its structures."""
    t = frame.timings
    return Sample(wall_s=t["total_s"] - t["build_s"], cpu_s=t["cpu_s"])


def _after_first_hits(frame: vc.Frame) -> float:
    """CPU seconds of a frame, without its camera paths."""
    return float(frame.timings["cpu_s"] - frame.timings["eye_paths_cpu_s"])


def _shares(frame: vc.Frame) -> dict[str, Any]:
    c = frame.counters
    queries = max(1, c["queries"])
    seconds: Sequence[str] = ("eye_paths", "contributions", "visibility", "shading")
    return {
        "share_occluded": c["occluded"] / queries,
        "share_boundary": c["boundary_queries"] / queries,
        "share_rays": c["rays"] / queries,
        "stages_cpu_s": {s: frame.timings[f"{s}_cpu_s"] for s in seconds},
    }

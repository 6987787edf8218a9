"""The quantized cache over frames: a camera path, a moving ball, tables kept or dropped."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from typing import Any

import numpy as np

import viscache as vc
from viscache.metrics.temporal import flicker
from viscache.scenes.shapes import bumpy_sphere
from viscache_lab.experiment import FIGURES, Band, Row, Trial
from viscache_lab.experiment.drawing import Panel, Panels, Series
from viscache_lab.figures.aqvc_claims import cameras
from viscache_lab.figures.aqvc_runs import Trade
from viscache_lab.figures.aqvc_setups import delta
from viscache_lab.figures.bands import aqvc as bands

C_E = 12.0
FRAMES, QUICK_FRAMES = 32, 4
SIZE, QUICK_SIZE = (320, 200), (160, 100)
TRIANGLES, QUICK_TRIANGLES = 100_000, 20_000
#: A ball crosses the living room between the camera and the corner.
BALL_PATH, BALL_RADIUS = ((-2.6, 1.2, -2.4), (-1.6, 1.2, -0.9)), 0.25
#: Shares of the reused bits that are traced: for counting, and for repair.
CHECK, REPAIR = 0.1, 0.1
WAYS = ("dropped", "kept", "epochs", "repaired")
#: Counters of the table.
CHECKED = ("checked_kept", "wrong_kept", "checked_fresh", "wrong_fresh")
COUNTED = ("queries", "rays", "reused_kept", *CHECKED)


@dataclass(slots=True)
class Sequence:
    """The frames of one path, with one way to keep tables."""

    frames: list[vc.Frame] = field(default_factory=list)

    def total(self, name: str) -> int:
        """A counter summed over all frames; 0 if absent."""
        return sum(int(f.counters.get(name, 0)) for f in self.frames)

    @property
    def ray_reduction(self) -> float:
        """Queries per ray, including rays for repair."""
        return self.total("queries") / max(1, self.total("rays"))

    def wrong(self, where: str) -> float:
        """Share of the checked bits that the ray contradicts; NaN without checked bits."""
        n = self.total(f"checked_{where}")
        return self.total(f"wrong_{where}") / n if n else float("nan")


@cache
def _apartment(triangles: int) -> vc.Scene:
    return delta(triangles)


@cache
def with_ball(triangles: int, x: float, y: float, z: float) -> vc.Scene:
    """The apartment with a ball in the air."""
    d = _apartment(triangles).description()
    vertices, faces = bumpy_sphere(BALL_RADIUS, 12).mesh(1.0)
    ball = np.asarray(vertices, np.float32) + np.array([x, y, z], np.float32)
    d.add_mesh(ball, np.asarray(faces, np.uint32), material=0, name="ball")
    return vc.Scene.from_description(d)


def views(path: str, quick: bool) -> list[tuple[vc.Scene, vc.Camera]]:
    """Scene and camera of every frame: "camera" moves the camera, "ball" the ball."""
    n = QUICK_FRAMES if quick else FRAMES
    triangles = QUICK_TRIANGLES if quick else TRIANGLES
    # Quick runs have the first frames, at the same spacing
    steps = np.linspace(0, 1, FRAMES)[:n]
    along = cameras(FRAMES)[:n]
    if path == "camera":
        return [(_apartment(triangles), view) for view in along]
    start, end = (np.array(place) for place in BALL_PATH)
    places = [(start + t * (end - start)).round(4).tolist() for t in steps]
    return [(with_ball(triangles, *place), along[0]) for place in places]


def run(
    shots: list[tuple[vc.Scene, vc.Camera]], way: str, refinement: str, size: tuple[int, int]
) -> Sequence:
    """Render all frames of a path in one way."""
    settings = vc.Aqvc(
        c_e=C_E,
        paper=vc.PaperForm(form="pairs", scale_free=True),
        refinement="on" if refinement == "on" else "off",
    )
    table = None
    if way != "dropped":
        repair = way == "repaired"
        table = vc.AqvcTable(table_bytes=64 << 20, check=REPAIR if repair else CHECK, repair=repair)
    made = Sequence()
    for scene, view in shots:
        if table is not None:
            table.moved(scene, forget=way == "epochs")
        made.frames.append(
            vc.render(scene, vc.Direct(), visibility=settings, size=size, camera=view, keep=table)
        )
    return made


@FIGURES.add(
    "aqvc-temporal",
    "tables kept, dropped or repaired while things move: rays, flicker, stale bits",
    sized=True,
)
def temporal(trial: Trial) -> None:
    """Both paths, with refinement on and off, and tables dropped, kept, forgotten and repaired."""
    pixels = trial.size or (QUICK_SIZE if trial.quick else SIZE)
    table = []
    curves: dict[str, Mapping[str, Sequence]] = {}
    for path in ("camera", "ball"):
        shots = views(path, trial.quick)
        exact = [
            vc.render(scene, vc.Direct(), visibility=vc.Exact(), size=pixels, camera=view)
            for scene, view in shots
        ]
        for refinement in ("off", "on"):
            ways = WAYS if path == "ball" else WAYS[:2]
            found = {way: run(shots, way, refinement, pixels) for way in ways}
            label = f"{path}, refinement {refinement}"
            trial.rows += _rows(path, label, found, exact)
            table += _table(path, refinement, found, exact)
            curves[label] = found
    trial.draw("aqvc-temporal.png", _panels(curves), (11.0, 5.5))
    trial.csv("aqvc-temporal.csv", table)
    trial.notes.append(
        f"{pixels[0]}x{pixels[1]}, {len(exact)} frames, the apartment's living room under 24 lamps "
        f"and a sun, C_E {C_E:g}, scale-free cells, one query at a time. Rays that only check are "
        "not counted, those that repair are."
    )


def _rows(path: str, label: str, found: Mapping[str, Sequence], exact: list[vc.Frame]) -> list[Row]:
    rows = []
    variance = {way: flicker(s.frames, exact) for way, s in found.items()}
    for way, s in found.items():
        f = variance[way]
        rel_l1 = np.mean([_error(a, b) for a, b in zip(s.frames, exact, strict=True)])
        rows.append(Row(f"{label}, {way}: RR over the path", s.ray_reduction))
        rows.append(
            Row(
                f"{label}, {way}: deviation of the error over time, of white",
                float(np.sqrt(f.error)),
                note=f"pictures' variance {f.above:+.2e} above the exact one's "
                f"{f.exact:.2e}; rel_l1 {rel_l1:.4f}",
            )
        )
        if s.total("checked_kept"):
            rows.append(
                Row(
                    f"{label}, {way}: share of wrong bits from frames before",
                    s.wrong("kept"),
                    note=f"of the frame's own {s.wrong('fresh'):.4f}; "
                    f"{s.total('checked_kept')} checked",
                )
            )

    def banded(what: str, value: float, band: Band) -> None:
        rows.append(Row(f"{label}: {what}", value, band=band))

    kept, dropped = found["kept"], found["dropped"]
    banded("RR kept over dropped", kept.ray_reduction / dropped.ray_reduction, bands.KEPT_REDUCTION)
    ratio = kept.wrong("kept") / kept.wrong("fresh") if kept.wrong("fresh") else float("inf")
    banded(
        "wrong bits from frames before, over the frame's own",
        ratio,
        bands.NOTHING_STALE if path == "camera" else bands.STALE,
    )
    if path == "camera":
        banded(
            "variance of the error, kept over dropped",
            variance["kept"].error / variance["dropped"].error,
            bands.KEPT_FLICKER,
        )
    else:
        banded(
            "rays with epochs over dropped",
            found["epochs"].total("rays") / dropped.total("rays"),
            bands.EPOCHS_FORGET,
        )
        banded(
            "wrong bits from frames before, repaired over kept",
            found["repaired"].wrong("kept") / kept.wrong("kept"),
            bands.REPAIR,
        )
    return rows


def _error(frame: vc.Frame, exact: vc.Frame) -> float:
    return Trade(frame=frame, exact=exact).rel_l1


def _table(
    path: str, refinement: str, found: Mapping[str, Sequence], exact: list[vc.Frame]
) -> list[dict[str, Any]]:
    return [
        {
            "path": path,
            "refinement": refinement,
            "table": way,
            "frame": i,
            **{name: frame.counters.get(name, 0) for name in COUNTED},
            "rel_l1": _error(frame, exact[i]),
        }
        for way, s in found.items()
        for i, frame in enumerate(s.frames)
    ]


def _panels(curves: Mapping[str, Mapping[str, Sequence]]) -> Panels:
    """Rays above, wrong bits below; a column per path and refinement."""

    def panel(label: str, found: Mapping[str, Sequence], above: bool) -> Panel:
        series = []
        for way, s in found.items():
            counters = [f.counters for f in s.frames]
            rays = [c["rays"] / c["queries"] for c in counters]
            wrong = [
                c["wrong_kept"] / max(1, c["checked_kept"]) for c in counters if "wrong_kept" in c
            ]
            if above or way != "dropped":
                y = rays if above else wrong
                series.append(Series(way, range(len(y)), y, "-", f"C{WAYS.index(way)}"))
        return Panel(
            series=series,
            title=label if above else "",
            x="" if above else "frame",
            y="rays per query" if above else "share of kept bits that are wrong",
            legend=above,
            more=lambda axes: axes.set_ylim(bottom=0),
        )

    return [[panel(*curve, above) for curve in curves.items()] for above in (True, False)]

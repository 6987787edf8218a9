"""The C_E slider of a notebook: time from a move to the picture in the cell's output."""

from __future__ import annotations

import importlib.util
import io
import statistics
import time
from typing import Any

import numpy as np

import viscache as vc
from viscache.base import tonemap
from viscache_lab.experiment import BENCHES, Trial
from viscache_lab.experiment.amounts import Sample, build_scene, timed

SCENE = "room?triangles=200000&lights=64"
QUICK_SCENE = "room?triangles=3000&lights=64"
MILLISECONDS_AT_MOST = 300.0
#: The slider of `notebooks/02_quantized_trade.ipynb`.
C_E = (2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64)


class Callback:
    """What the notebook does when the slider moves, with each stage timed."""

    def __init__(self, scene: vc.Scene, size: tuple[int, int]) -> None:
        self.scene, self.size = scene, size
        self.exact = vc.render(scene, vc.Direct(), size=size)
        self.exposure = tonemap.display_exposure(self.exact.image)
        self.stages: dict[str, Sample] = {}

    def __call__(self, c_e: float) -> tuple[vc.Frame, str]:
        self.stages["render"], frame = timed(lambda: self.frame(c_e))
        self.stages["metric"], error = timed(
            lambda: vc.metrics.compare(frame, self.exact, metrics=["rel_l1"])["rel_l1"]
        )
        saved = frame.counters["ray_reduction"]
        return frame, f"{saved:.1f} queries per ray, error {100 * error:.2f} %"

    def frame(self, c_e: float, threads: int | None = None) -> vc.Frame:
        return vc.render(
            self.scene, vc.Direct(), visibility=vc.Aqvc(c_e=c_e), size=self.size, threads=threads
        )


@BENCHES.add(
    "notebook-slider", "the C_E slider of a notebook, from the move to the picture that is shown"
)
def notebook_slider(trial: Trial) -> None:
    """64 lights of the room at 480×270, 1 sample, on all cores; moved to every C_E and back."""
    if importlib.util.find_spec("ipywidgets") is None:
        trial.skip("the C_E slider", "ipywidgets is not installed")
        return
    size, turns = ((120, 68), 1) if trial.quick else ((480, 270), 5)
    callback = Callback(build_scene(QUICK_SCENE if trial.quick else SCENE), size)
    began = time.perf_counter()
    view = vc.notebook.sliders(
        callback, c_e=list(C_E), first={"c_e": C_E[-1]}, exposure=callback.exposure
    )
    first_ms = 1000 * (time.perf_counter() - began)
    moves: dict[int, list[dict[str, Sample]]] = {c_e: [] for c_e in C_E}
    for turn in range(turns):
        for c_e in C_E if turn % 2 == 0 else (*C_E[-2::-1], C_E[-1]):
            moves[c_e].append(_moved(view, callback, c_e))
    wrong = sum(_differs(view, callback, c_e) for c_e in C_E)
    trial.check("bytes of shown pictures that are not those of vc.render", wrong, 0)
    expected = 1 + len(C_E) * (turns + 1)  # a slider reports changes only
    trial.check("moves without a picture", abs(expected - len(view.milliseconds)), 0)
    rows = [_row(c_e, taken) for c_e, taken in moves.items()]
    worst = max(rows, key=lambda row: row["wall_ms"])
    trial.at_most(
        f"C_E slider, 64 lights, {size[0]}x{size[1]}: slowest move",
        worst["wall_ms"],
        "ms",
        None if trial.quick else MILLISECONDS_AT_MOST,
        c_e=worst["c_e"],
        first_ms=first_ms,
        moves=rows,
    )
    trial.notes += [_sentence(row) for row in rows]


def _moved(view: vc.notebook.Sliders, callback: Callback, c_e: float) -> dict[str, Sample]:
    """Move the slider; return the duration of each stage and the total."""
    whole, _ = timed(lambda: setattr(view.widgets["c_e"], "value", c_e))
    stages = dict(callback.stages)
    picture = {
        clock: getattr(whole, clock) - sum(getattr(s, clock) for s in stages.values())
        for clock in ("wall_s", "cpu_s")
    }
    return {**stages, "picture": Sample(**picture), "move": whole}


def _differs(view: vc.notebook.Sliders, callback: Callback, c_e: int) -> int:
    """Number of bytes of the tone-mapped picture that differ from a single-threaded frame."""
    from PIL import Image

    _moved(view, callback, c_e)
    shown = np.asarray(Image.open(io.BytesIO(view.picture.value)).convert("RGB"))
    frame = callback.frame(c_e, threads=1)
    wanted = tonemap.to_srgb8(frame.image, callback.exposure)
    return wanted.size if shown.shape != wanted.shape else int((shown != wanted).sum())


def _row(c_e: int, taken: list[dict[str, Sample]]) -> dict[str, Any]:
    """Medians of the moves to one C_E, in milliseconds."""

    def median(stage: str, clock: str) -> float:
        return round(float(1000 * statistics.median(getattr(t[stage], clock) for t in taken)), 2)

    row: dict[str, Any] = {
        "c_e": c_e,
        "wall_ms": median("move", "wall_s"),
        "cpu_ms": median("move", "cpu_s"),
    }
    for stage in ("render", "metric", "picture"):
        row |= {f"{stage}_ms": median(stage, "wall_s"), f"{stage}_cpu_ms": median(stage, "cpu_s")}
    return row


def _sentence(row: dict[str, Any]) -> str:
    return (
        f"C_E {row['c_e']}: {row['wall_ms']:.0f} ms, CPU {row['cpu_ms']:.0f} ms"
        f" (render {row['render_cpu_ms']:.0f}, metric {row['metric_cpu_ms']:.1f},"
        f" tone curve, PNG and widget {row['picture_cpu_ms']:.1f})"
    )

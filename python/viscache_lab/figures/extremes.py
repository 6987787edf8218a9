"""The map of where numbers hold: error over the unit of length, the offset and C_E."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from viscache.base.progress import progress_bar
from viscache.plots.drawing import new_figure
from viscache.plots.sweeps import MARKERS
from viscache.sweeps.swept import colors_for
from viscache_lab.extremes.chart import AXES, GROWTH, holding, measure
from viscache_lab.figures.drawing import save_figure
from viscache_lab.figures.outcome import Band, Outcome, Row
from viscache_lab.figures.registry import figure
from viscache_lab.figures.vlf_tracers import write_csv

#: Errors below are drawn here: pictures whose bytes are equal.
FLOOR = 1e-8
PROMISED = "docs/limits.md promises it"


@figure("extremes", "where numbers hold: error over scale, distance from the origin and C_E")
def extremes(folder: Path, quick: bool, progress: bool) -> Outcome:
    """The lit Cornell box at every scale and offset, and with cells of every size."""
    with progress_bar(progress, unit="frame") as told:
        rows = measure(quick, told)
    outcome = Outcome()
    methods = list(dict.fromkeys(r["method"] for r in rows if r["axis"] == "scale"))
    for method in methods:
        low, high = holding(rows, "scale", method)
        _, far = holding(rows, "offset", method)
        outcome.rows += [
            Row(f"{method}: least unit of length", low, band=Band(0, 1e-6, PROMISED)),
            Row(f"{method}: largest unit of length", high, band=Band(1e6, 1e99, PROMISED)),
            Row(f"{method}: offset in sizes of the scene", far, band=Band(1e3, 1e99, PROMISED)),
        ]
    for method in dict.fromkeys(r["method"] for r in rows if r["axis"] == "c_e"):
        errors = {r["x"]: r["error"] for r in rows if r["axis"] == "c_e" and r["method"] == method}
        outcome.rows += [
            Row(f"{method}: rel_l1 at the least C_E", errors[min(errors)],
                band=Band(0, 1e-2, "cells of one eye point approximate nothing but lights")),
            Row(f"{method}: rel_l1 at the largest C_E over that at 1",
                errors[max(errors)] / max(errors[1.0], 1e-12),
                band=Band(1, 1e99, "larger cells err more")),
        ]  # fmt: skip
    outcome.files += [
        _drawn(rows, folder / "extremes.png"),
        write_csv(folder / "extremes.csv", rows),
    ]
    outcome.notes.append(
        f"An error holds where it grows by less than {GROWTH:.0%} of the light. The picture is the"
        " lit Cornell box, 48 × 32 pixels."
    )
    return outcome


def _drawn(rows: list[dict[str, Any]], path: Path) -> Path:
    """A panel per axis."""
    drawing = new_figure(15.0, 5.4)
    panels = drawing.subplots(1, len(AXES), sharey=True)
    for panel, (axis, (words, _, _)) in zip(panels, AXES.items(), strict=True):
        mine = [r for r in rows if r["axis"] == axis]
        methods = list(dict.fromkeys(r["method"] for r in mine))
        for i, (method, color) in enumerate(zip(methods, colors_for(len(methods)), strict=False)):
            points = sorted((r["x"], max(r["error"], FLOOR)) for r in mine if r["method"] == method)
            xs, ys = zip(*points, strict=True)
            marker = MARKERS[i % len(MARKERS)]
            panel.plot(xs, ys, color=color, marker=marker, ms=3, lw=1, label=method)
        panel.set(xscale="log", yscale="log", xlabel=words)
        panel.grid(True, which="major", color="0.9")
        panel.set_axisbelow(True)
        panel.legend(fontsize=5.5, frameon=False, loc="upper center", ncols=2,
                     bbox_to_anchor=(0.5, -0.13))  # fmt: skip
    panels[0].set_ylabel("rel_l1 against exact visibility of the unit scene")
    return save_figure(drawing, path)

"""The map of where numbers hold: error over the unit of length, the offset and C_E."""

from __future__ import annotations

from typing import Any

from viscache.base.progress import progress_bar
from viscache.plots.sweeps import MARKERS
from viscache.sweeps.swept import colors_for
from viscache_lab.experiment import FIGURES, Band, Trial
from viscache_lab.experiment.drawing import Panel, Series
from viscache_lab.extremes.chart import AXES, GROWTH, holding, measure

#: Errors below are drawn here: pictures whose bytes are equal.
FLOOR = 1e-8
PROMISED = "docs/limits.md promises it"


@FIGURES.add("extremes", "where numbers hold: error over scale, distance from the origin and C_E")
def extremes(trial: Trial) -> None:
    """The lit Cornell box at every scale and offset, and with cells of every size."""
    with progress_bar(trial.progress, unit="frame") as told:
        rows = measure(trial.quick, told)
    methods = list(dict.fromkeys(r["method"] for r in rows if r["axis"] == "scale"))
    for method in methods:
        low, high = holding(rows, "scale", method)
        _, far = holding(rows, "offset", method)
        trial.row(f"{method}: least unit of length", low, band=Band(0, 1e-6, PROMISED))
        trial.row(f"{method}: largest unit of length", high, band=Band(1e6, 1e99, PROMISED))
        trial.row(f"{method}: offset in sizes of the scene", far, band=Band(1e3, 1e99, PROMISED))
    for method in dict.fromkeys(r["method"] for r in rows if r["axis"] == "c_e"):
        errors = {r["x"]: r["error"] for r in rows if r["axis"] == "c_e" and r["method"] == method}
        trial.row(
            f"{method}: rel_l1 at the least C_E",
            errors[min(errors)],
            band=Band(0, 1e-2, "cells of one eye point approximate nothing but lights"),
        )
        trial.row(f"{method}: rel_l1 at the largest C_E over that at 1",
                errors[max(errors)] / max(errors[1.0], 1e-12),
                band=Band(1, 1e99, "larger cells err more"))  # fmt: skip
    panels = [_panel(rows, axis, words) for axis, (words, _, _) in AXES.items()]
    trial.draw("extremes.png", [panels], (15.0, 5.4))
    trial.csv("extremes.csv", rows)
    trial.notes.append(
        f"An error holds where it grows by less than {GROWTH:.0%} of the light. The picture is the"
        " lit Cornell box, 48 × 32 pixels."
    )


def _panel(rows: list[dict[str, Any]], axis: str, words: str) -> Panel:
    mine = [r for r in rows if r["axis"] == axis]
    methods = list(dict.fromkeys(r["method"] for r in mine))
    series = []
    for i, (method, color) in enumerate(zip(methods, colors_for(len(methods)), strict=False)):
        points = sorted((r["x"], max(r["error"], FLOOR)) for r in mine if r["method"] == method)
        style = f"{MARKERS[i % len(MARKERS)]}-"
        series.append(Series.through(method, points, style, color))

    def legend(axes: Any) -> None:
        axes.legend(
            fontsize=5.5, frameon=False, loc="upper center", ncols=2, bbox_to_anchor=(0.5, -0.13)
        )

    y = "rel_l1 against exact visibility of the unit scene"
    return Panel(series=series, x=words, y=y, logarithmic="xy", legend=False, more=legend)

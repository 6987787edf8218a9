"""Error over time: a curve per setting, a point per pass."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from viscache.passes.over_time import ERRORS
from viscache.plots import labels
from viscache.plots.drawing import new_figure
from viscache.plots.sweeps import MARKERS, ticks_1_2_5
from viscache.settings.checks import require
from viscache.sweeps.swept import colors_for

if TYPE_CHECKING:
    import xarray
    from matplotlib.figure import Figure

#: What can be along the horizontal axis.
COSTS = ("cpu_s", "wall_s", "rays", "pass")
#: Names of the axes; those of sweeps are of single frames.
WORDS = {
    "cpu_s": "CPU seconds of all passes so far",
    "wall_s": "seconds of all passes so far",
    "rays": "shadow rays of all passes so far",
    "pass": "passes",
}


def error_over_time(ds: xarray.Dataset, x: str = "cpu_s", y: str = "nmse") -> Figure:
    """Curves of error over time, one point per pass, of biased, corrected and exact passes.

    Parameters
    ----------
    ds : Dataset of `viscache.passes_over_time`
    x : {"cpu_s", "wall_s", "rays", "pass"}
    y : {"nmse", "rel_mse", "rel_l1_reflected"}

    Returns
    -------
    Figure
        Both axes are logarithmic. The shade around `nmse` is its 95 % interval. Points whose error
        is not positive, below the noise of the references, are left out.
    """
    figure = new_figure(6.4, 4.2)
    draw_over_time(figure.add_subplot(), ds, x, y)
    return figure


def draw_over_time(
    axes: Any, ds: xarray.Dataset, x: str = "cpu_s", y: str = "nmse", *, legend: bool = True
) -> None:
    """Draw the curves of `error_over_time` into axes of matplotlib."""
    require(x in COSTS, f"x must be one of {COSTS}", x)
    require(y in ERRORS, f"y must be one of {tuple(ERRORS)}", y)
    names = [str(n) for n in ds["setting"].values]
    for i, (name, color) in enumerate(zip(names, colors_for(len(names)), strict=False)):
        mine = ds.sel(setting=name)
        across, up = (np.broadcast_to(mine[v].values, (ds.sizes["pass"],)) for v in (x, y))
        shown = up > 0
        style: dict[str, Any] = {"marker": MARKERS[i % len(MARKERS)], "ms": 3.5, "lw": 1.3}
        axes.plot(across[shown], up[shown], color=color, label=name, **style)
        if y == "nmse":
            low, high = mine["nmse_low"].values, mine["nmse_high"].values
            floor = np.maximum(low, up / 10)
            axes.fill_between(
                across[shown], floor[shown], high[shown], color=color, alpha=0.12, lw=0
            )
    axes.set_xscale("log")
    axes.set_yscale("log")
    for axis in (axes.xaxis, axes.yaxis):
        ticks_1_2_5(axis)
    axes.set(xlabel=WORDS[x], ylabel=labels.mathtext(y))
    axes.grid(True, which="major", color="0.9")
    axes.set_axisbelow(True)
    if legend:
        axes.legend(fontsize=8, frameon=False)

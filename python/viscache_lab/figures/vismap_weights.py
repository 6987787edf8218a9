"""Figure 5 of the visibility-map paper: a record's weight over distance and angle."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from viscache.plots.drawing import new_figure
from viscache.vismap.equations import record_weight
from viscache_lab.experiment import FIGURES, Row, Trial
from viscache_lab.figures.bands import vismap as bands
from viscache_lab.figures.vismap_printed import STEEPNESS, THETA_MAX_DEG

#: Share of d_max at which the slope is taken.
STEP = 1e-3


@FIGURES.add("vismap-fig5", "the weighting function")
def figure5(trial: Trial) -> None:
    """w of Eq. 9 within the limits of the search, seen from above left and from below right."""
    far, tilted = 1.0, math.radians(THETA_MAX_DEG)
    slope = (_weight(STEP, 0.0) - _weight(0.0, 0.0)) / STEP
    trial.rows += [
        Row(
            "least weight, at d_max and 30 deg",
            _weight(far, tilted),
            printed="about 0.7",
            band=bands.LEAST_WEIGHT,
        ),
        Row("weight at d_max and 0 deg", _weight(far, 0.0), band=bands.EDGE_WEIGHT),
        Row("weight at 0 and 30 deg", _weight(0.0, tilted), band=bands.EDGE_WEIGHT),
        Row("first slope over d / d_max", slope, band=bands.FIRST_SLOPE),
    ]
    trial.save(_picture(), "vismap-fig5.png", dpi=150)


def _weight(t: Any, theta: Any) -> Any:
    return record_weight(t, theta, STEEPNESS)


def _picture() -> Any:
    t, theta = np.meshgrid(np.linspace(0, 1, 41), np.linspace(0, THETA_MAX_DEG, 31))
    weight = _weight(t, np.radians(theta))
    figure = new_figure(9.0, 4.0)
    for column, azimuth in ((1, -125), (2, -35)):
        axes: Any = figure.add_subplot(1, 2, column, projection="3d")
        axes.plot_surface(t, theta, weight, cmap="cividis", vmin=0.6, vmax=1.0, lw=0)
        axes.set(
            xlabel="distance $d/d_{max}$", ylabel=r"normal difference $\theta$ [°]", zlim=(0.6, 1.0)
        )
        axes.view_init(elev=25, azim=azimuth)
    return figure

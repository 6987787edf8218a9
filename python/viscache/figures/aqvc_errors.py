"""Shape and size of a cached picture's error, and means with their confidence."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from viscache import tonemap
from viscache.frame import Frame

__all__ = ["Interval", "autocorrelation", "bias", "error_plane", "mean_interval", "stray_light"]

Plane = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Interval:
    """A mean and half the width of its 95 % confidence interval."""

    mean: float
    half: float

    def __str__(self) -> str:
        return f"{100 * self.mean:+.3f} ± {100 * self.half:.3f} %"


def mean_interval(values: Sequence[float]) -> Interval:
    """By Student's t, values taken as independent."""
    from scipy.stats import t

    n = len(values)
    spread = float(np.std(values, ddof=1) / np.sqrt(n))
    return Interval(float(np.mean(values)), float(t.ppf(0.975, n - 1)) * spread)


def error_plane(frame: Frame, exact: Frame) -> Plane:
    """Error of the luminance: (H, W)."""
    cached, truth = (np.asarray(tonemap.luminance(f.image), np.float64) for f in (frame, exact))
    return cached - truth


def bias(frame: Frame, exact: Frame) -> float:
    """Relative error of the picture's energy without what shines itself."""
    cached, truth = (
        np.asarray(f.image, np.float64) - np.asarray(f.layers["emitted"], np.float64)
        for f in (frame, exact)
    )
    return float((cached - truth).sum() / truth.sum())


def autocorrelation(error: Plane, lag: int) -> float:
    """Mean product of errors `lag` pixels apart, along rows and columns, over the mean square.

    1 where the error is constant, 0 for white noise; NaN where there is no error.
    """
    square = float((error**2).mean())
    if square == 0:
        return float("nan")
    right = (error[:, lag:] * error[:, :-lag]).mean()
    down = (error[lag:] * error[:-lag]).mean()
    return float((right + down) / (2 * square))


def stray_light(frame: Frame, exact: Frame) -> float:
    """Light on pixels that are black in the exact picture, over all light of that picture."""
    cached, truth = (np.asarray(f.image, np.float64).sum(axis=2) for f in (frame, exact))
    return float(cached[truth == 0].sum() / truth.sum())

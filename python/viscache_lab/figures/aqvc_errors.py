"""Error measures of cached pictures, and means with confidence intervals."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

import viscache as vc


@dataclass(frozen=True, slots=True)
class Interval:
    """A mean, and half the width of its 95 % confidence interval."""

    mean: float
    half: float

    def __str__(self) -> str:
        return f"{100 * self.mean:+.3f} ± {100 * self.half:.3f} %"


def mean_interval(values: Sequence[float]) -> Interval:
    """By Student's t, for independent values."""
    from scipy.stats import t

    n = len(values)
    spread = float(np.std(values, ddof=1) / np.sqrt(n))
    return Interval(float(np.mean(values)), float(t.ppf(0.975, n - 1)) * spread)


def bias(frame: vc.Frame, exact: vc.Frame) -> float:
    """Relative error of the picture's energy, without emitted light."""
    cached, truth = (
        np.asarray(f.image, np.float64) - np.asarray(f.layers["emitted"], np.float64)
        for f in (frame, exact)
    )
    return float((cached - truth).sum() / truth.sum())


def stray_light(frame: vc.Frame, exact: vc.Frame) -> float:
    """Light on pixels that are black in the exact picture, over that picture's total light."""
    cached, truth = (np.asarray(f.image, np.float64).sum(axis=2) for f in (frame, exact))
    return float(cached[truth == 0].sum() / truth.sum())

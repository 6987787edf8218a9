"""Time to equal error of two unbiased renderers, from runs at equal samples."""

from __future__ import annotations

import math
import statistics
from collections.abc import Sequence

from viscache.metrics import confidence_interval

__all__ = ["log_interval"]


def log_interval(ratios: Sequence[float]) -> tuple[float, float, float]:
    """Geometric mean of independent ratios and its 95 % interval.

    Parameters
    ----------
    ratios : sequence of float > 0
        One per turn, at least two.

    Returns
    -------
    tuple of float
        The mean, and the ends of Student's interval of the logarithm's mean.

    Raises
    ------
    ValueError
        There are fewer than two ratios, or one is not above 0.
    """
    if len(ratios) < 2 or not all(r > 0 and math.isfinite(r) for r in ratios):
        raise ValueError(f"ratios must be two or more finite numbers > 0, got {list(ratios)}")
    logs = [math.log(r) for r in ratios]
    low, high = confidence_interval(logs)
    return math.exp(statistics.fmean(logs)), math.exp(low), math.exp(high)

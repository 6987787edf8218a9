"""Student's t of pictures: does a difference of means differ from 0, and what would have been seen?

Each side is a stack of independent pictures. What is compared are sums over many pixels, one value
per picture: sums are nearly normal, while single pixels of corrected frames have heavy tails.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]

#: Differences that are rounding, relative to the cell and to the picture.
ROUNDING = 2e-5


@dataclass(frozen=True, kw_only=True, slots=True)
class Difference:
    """Differences of means, and what chance allows them; arrays of one shape."""

    value: Floats
    error: Floats  #: standard error, at least that of rounding
    freedom: Floats  #: degrees of freedom

    @property
    def t(self) -> Floats:
        return self.value / np.maximum(self.error, 1e-300)

    @property
    def p(self) -> Floats:
        """Two-sided."""
        from scipy.stats import t  # type: ignore[import-untyped,unused-ignore]

        return np.asarray(2 * t.sf(np.abs(self.t), self.freedom))


def blocks(images: Floats, edge: int) -> Floats:
    """Means over blocks of about edge × edge pixels: (N, rows, columns, C) of (N, H, W, C)."""
    for axis in (1, 2):
        parts = max(1, round(images.shape[axis] / edge))
        cut = np.array_split(images, parts, axis=axis)
        images = np.stack([part.mean(axis=axis) for part in cut], axis=axis)
    return images


def welch(a: Floats, b: Floats, tolerance: float = ROUNDING) -> Difference:
    """Of two independent stacks (N, ...) and (M, ...); M = 1 is a picture without noise.

    `tolerance` counts as noise of that size, relative to the cell and to the picture: noise far
    below rounding says nothing about a difference of that size.
    """
    n, m = len(a), len(b)
    va = a.var(axis=0, ddof=1) / n
    vb = b.var(axis=0, ddof=1) / m if m > 1 else np.zeros_like(va)
    mean = b.mean(axis=0)
    rounding = tolerance * (np.abs(mean) + np.abs(b.mean()))
    freedom = (va + vb) ** 2 / np.maximum(
        va**2 / (n - 1) + (vb**2 / (m - 1) if m > 1 else 0), 1e-300
    )
    freedom = np.where((va + vb) > rounding**2, freedom, 1e9)
    return Difference(
        value=a.mean(axis=0) - mean,
        error=np.sqrt(va + vb + rounding**2),
        freedom=np.maximum(freedom, 1.0),
    )


def difference(a: Floats, b: Floats, *, paired: bool) -> Difference:
    """Of stacks (N, ...); paired: of pictures that share their noise, one by one."""
    if not paired:
        return welch(a, b)
    mean = b.mean(axis=0)
    return welch(a - b + mean, mean[None])


def detectable(error: float, freedom: float, alpha: float, power: float) -> float:
    """The difference that a two-sided test at level `alpha` finds with probability `power`.

    If the noise is as estimated: the noncentral t distribution.
    """
    return _shift(freedom, alpha, power) * error


def _shift(freedom: float, alpha: float, power: float) -> float:
    """The noncentrality, in standard errors."""
    from scipy.optimize import brentq  # type: ignore[import-untyped,unused-ignore]
    from scipy.stats import nct, norm, t

    if freedom > 1e6:
        return float(norm.isf(alpha / 2) + norm.ppf(power))
    limit = float(t.isf(alpha / 2, freedom))

    def missing(shift: float) -> float:
        return float(nct.sf(limit, freedom, shift)) - power

    high = limit + 4.0
    while missing(high) < 0:
        high *= 2
    return float(brentq(missing, 0.0, high, xtol=1e-6))


def frames_for(wanted: float, error: float, frames: int, alpha: float, power: float) -> int:
    """Frames that find a difference of `wanted`, given the error of this many frames."""

    def enough(n: int) -> bool:
        return _shift(n - 1.0, alpha, power) * error * math.sqrt(frames / n) <= wanted

    low = high = max(frames, 2)
    while not enough(high):
        low, high = high, 2 * high
    while high - low > max(1, low // 20):
        middle = (low + high) // 2
        low, high = (low, middle) if enough(middle) else (middle, high)
    return high

"""Do two stacks of pictures have the same expectation? Block by block, with the power to tell.

Each stack holds the block means of independent pictures, one per seed. The variance of a block's
mean is estimated from the seeds. A block agrees within 3 σ + 1 %; pictures agree if 95 % of their
blocks do, and their energies do too, so that a difference in few blocks counts by its size.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]

#: A block agrees within this many standard deviations plus this share of the reference.
SIGMAS, TOLERANCE = 3.0, 0.01
#: Pictures agree if at least this share of the blocks does.
SHARE = 0.95
#: Darker than this share of the mean picture, a block is black: its tolerance does not shrink.
BLACK = 1e-3
#: A comparison that finds no smaller difference of a block compares nothing.
BLIND = 0.5
#: One-sided 95 % of a normal distribution.
_QUANTILE = 1.6449


def block_means(picture: npt.NDArray[Any], edge: int) -> Array:
    """Means of edge × edge blocks of a picture (H, W, C); what does not fill one is left out."""
    height, width, channels = picture.shape
    rows, columns = height // edge, width // edge
    cut = np.asarray(picture[: rows * edge, : columns * edge], np.float64)
    return np.asarray(cut.reshape(rows, edge, columns, edge, channels).mean(axis=(1, 3)))


@dataclass(frozen=True, kw_only=True, slots=True)
class Comparison:
    """The outcome of `compare`."""

    share: float  # share of the blocks within 3 σ + 1 %
    z: Array  # signed difference of each block (rows, columns, channels) in standard deviations
    worst_z: float  # the z of largest size among the blocks that do not agree, else among all
    energy_ours: float
    energy_theirs: float
    energy_sigma: float  # standard deviation of the difference of both
    power: float  # relative difference of a block that is found at 95 %: its median over lit blocks
    power_weak: float  # the same, at the 90th percentile of lit blocks

    @property
    def energy_difference(self) -> float:
        """Relative difference of the energies; 0 if both are black."""
        if self.energy_theirs == 0:
            return 0.0 if self.energy_ours == 0 else float("inf")
        return self.energy_ours / self.energy_theirs - 1

    @property
    def energies_agree(self) -> bool:
        """Whether the energies are within 3 σ + 1 %."""
        allowed = SIGMAS * self.energy_sigma + TOLERANCE * abs(self.energy_theirs)
        return abs(self.energy_ours - self.energy_theirs) <= allowed

    @property
    def informative(self) -> bool:
        """Whether a block that is half as bright again would be found: not where all is black."""
        return self.power <= BLIND

    @property
    def agrees(self) -> bool:
        """Whether the pictures have the same expectation, as far as the noise shows."""
        return self.share >= SHARE and self.energies_agree


def compare(ours: npt.ArrayLike, theirs: npt.ArrayLike) -> Comparison:
    """Compare block means (n >= 2, rows, columns, channels) of independent pictures.

    n may differ. Non-finite blocks do not agree.
    """
    a, b = np.asarray(ours, np.float64), np.asarray(theirs, np.float64)
    if a.shape[1:] != b.shape[1:] or a.ndim != 4 or min(len(a), len(b)) < 2:
        raise ValueError(
            f"stacks must have shape (>= 2, rows, columns, C), got {a.shape}, {b.shape}"
        )
    finite = np.isfinite(a).all(axis=0) & np.isfinite(b).all(axis=0)
    a, b = np.nan_to_num(a, posinf=0.0, neginf=0.0), np.nan_to_num(b, posinf=0.0, neginf=0.0)
    mine, other = a.mean(axis=0), b.mean(axis=0)
    sigma = np.sqrt(a.var(axis=0, ddof=1) / len(a) + b.var(axis=0, ddof=1) / len(b))
    floor = BLACK * max(float(other.mean()), 1e-12)
    level = np.maximum(np.abs(other), floor)
    difference = mine - other
    inside = (np.abs(difference) <= SIGMAS * sigma + TOLERANCE * level) & finite
    # Noise below rounding of single precision says nothing about a difference of that size
    z = difference / np.maximum(sigma, 1e-6 * level)
    wrong = z[~inside]
    tell = (SIGMAS + _QUANTILE) * sigma / level + TOLERANCE
    lit = tell[np.abs(other) > floor]
    whole_a, whole_b = a.mean(axis=(1, 2, 3)), b.mean(axis=(1, 2, 3))
    return Comparison(
        share=float(inside.mean()),
        z=np.where(finite, z, np.inf),
        worst_z=float(max(wrong if wrong.size else z.ravel(), key=abs, default=0.0)),
        energy_ours=float(whole_a.mean()) if finite.all() else float("nan"),
        energy_theirs=float(whole_b.mean()),
        energy_sigma=float(np.sqrt(whole_a.var(ddof=1) / len(a) + whole_b.var(ddof=1) / len(b))),
        power=float(np.median(lit)) if lit.size else float("inf"),
        power_weak=float(np.quantile(lit, 0.9)) if lit.size else float("inf"),
    )

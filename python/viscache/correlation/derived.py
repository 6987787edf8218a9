"""Quantities derived from the correlation: correlation lengths and predicted variance."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from viscache.settings.checks import require

if TYPE_CHECKING:
    import xarray

Floats = npt.NDArray[np.float64]

#: Bins with fewer pairs have too little data: white in plots, excluded here.
ENOUGH_PAIRS = 100
#: Minimum mean ρ̄ of the box of high correlation, over which spatial maps are averaged.
HIGH_CORRELATION = 0.8
LEVELS = (0.9, 0.5)


@dataclass(frozen=True, slots=True)
class Box:
    """A box at the corner of the table: d < d_max and θ < theta_max_deg."""

    d_max: float
    theta_max_deg: float
    mean: float
    """Mean ρ of its pairs."""


def correlation_lengths(dataset: xarray.Dataset, levels: tuple[float, ...] = LEVELS) -> Floats:
    """Distance at which ρ̄ falls to a level, for each θ.

    ρ̄ is interpolated linearly between bin centres. Bins with n < 100 are skipped.

    Returns
    -------
    (levels, T) float64
        In scene units. 0 if ρ̄ starts below the level; inf if it never falls to it; NaN if no bin
        of that θ has enough pairs.
    """
    d = dataset["d"].values
    mean, n = dataset["mean"].values, dataset["n"].values
    found = np.full((len(levels), mean.shape[1]), np.nan)
    for t in range(mean.shape[1]):
        enough = n[:, t] >= ENOUGH_PAIRS
        for k, level in enumerate(levels):
            found[k, t] = _falls_to(d[enough], mean[enough, t], level)
    return found


def _falls_to(d: Floats, mean: Floats, level: float) -> float:
    if not len(d):
        return np.nan
    below = np.flatnonzero(mean <= level)
    if not len(below):
        return np.inf
    i = int(below[0])
    if i == 0:
        return 0.0
    share = (mean[i - 1] - level) / (mean[i - 1] - mean[i])
    return float(d[i - 1] + share * (d[i] - d[i - 1]))


def predicted_variance_ratio(
    dataset: xarray.Dataset, spacing: npt.ArrayLike, theta_max_deg: float = 10.0
) -> Floats:
    """Variance left by a control variate from records with this spacing: mean of 1 − ρ².

    With one record per spacing² of surface, a record is used for the points within r = spacing/√π,
    a disc of that area. The mean is over all pairs with d < r and θ < theta_max_deg. For evenly
    distributed points, these pairs have the same distribution of d as a point and its record. With
    the best α a control variate leaves 1 − ρ² of the variance (Eq. 5 of the paper).

    Parameters
    ----------
    dataset : Dataset of `viscache.correlation.measure`
    spacing : float or (S,) float > 0
        Scene units.
    theta_max_deg : float
        Largest angle between the normals of record and point; at least the first bin of θ.

    Returns
    -------
    (S,) float64
        NaN if no pair is that near, or if r lies beyond the bins.

    Raises
    ------
    ValueError
        A spacing is not > 0, or the angle is below the end of the first bin.
    """
    radius = np.atleast_1d(np.asarray(spacing, dtype=np.float64)) / np.sqrt(np.pi)
    require(bool((radius > 0).all()), "spacing must be > 0", spacing)
    kept = dataset["theta_high"].values <= theta_max_deg
    require(bool(kept.any()), "theta_max_deg must reach the end of the first bin", theta_max_deg)
    weight = pairs_of_bins(dataset)[:, kept]
    left = np.nan_to_num(dataset["variance_ratio"].values[:, kept]) * weight
    edges = np.append(dataset["d_low"].values, dataset["d_high"].values[-1])
    finite = np.isfinite(edges)
    # Pairs within r; between the edges they are proportional to the area, linear in r²
    pairs = np.append(0.0, np.cumsum(weight.sum(axis=1)))[finite]
    sums = np.append(0.0, np.cumsum(left.sum(axis=1)))[finite]
    inside, total = (np.interp(radius**2, edges[finite] ** 2, v) for v in (pairs, sums))
    reached = (radius <= edges[finite][-1] * (1 + 1e-12)) & (inside > 0)
    return np.where(reached, total / np.where(inside > 0, inside, 1.0), np.nan)


def high_correlation_box(dataset: xarray.Dataset, least: float = HIGH_CORRELATION) -> Box:
    """The largest box d < d_max, θ < θ_max whose pairs have a mean ρ of at least `least`.

    The size of a box is the area of its bins with n >= 100, so that empty parts of the table do not
    count. Of equal ones, the box with the smaller θ_max, then d_max, is chosen. If not even the
    first bin reaches `least`, that bin is returned.
    """
    weight = pairs_of_bins(dataset)
    mean = np.nan_to_num(dataset["mean"].values)
    d_high, theta_high = dataset["d_high"].values, dataset["theta_high"].values
    pairs, sums = _corner_sums(weight), _corner_sums(weight * mean)
    averages = sums / np.where(pairs > 0, pairs, 1.0)
    widths = np.where(np.isfinite(d_high), d_high - dataset["d_low"].values, 0.0)
    heights = theta_high - dataset["theta_low"].values
    area = _corner_sums(np.outer(widths, heights) * (dataset["n"].values >= ENOUGH_PAIRS))
    fits = (averages >= least) & np.isfinite(d_high)[:, None] & (area > 0)
    if not fits.any():
        return Box(float(d_high[0]), float(theta_high[0]), float(averages[0, 0]))
    largest = fits & (area >= area[fits].max() * (1 - 1e-12))
    best_d, best_theta = min(zip(*np.nonzero(largest), strict=True), key=lambda at: (at[1], at[0]))
    average = float(averages[best_d, best_theta])
    return Box(float(d_high[best_d]), float(theta_high[best_theta]), average)


def _corner_sums(values: Floats) -> Floats:
    """Cumulative sums of the bins from the corner d = θ = 0."""
    return np.asarray(values.cumsum(axis=0).cumsum(axis=1))


def pairs_of_bins(dataset: xarray.Dataset) -> Floats:
    """Number of pairs of each bin; sampled counts are scaled up to all pairs."""
    share = dataset["pair_share"].values
    return np.asarray(dataset["n"].values / np.where(share > 0, share, 1.0)[:, None])

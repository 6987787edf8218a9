"""Bins of pairs over distance d and angle θ, and the bins of the two slices.

Pairs are counted once, in cells so fine that every bin of the table and of both slices is a union
of cells. Cells are half-open, and counts and sums are integers, so the sums of a bin are exactly
those of its pairs.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from viscache.settings.checks import checked_floats, is_number, require

Floats = npt.NDArray[np.float64]

#: Number of bins of each slice, and the default for the table.
N_SLICE = 64
N_D = 128
N_THETA = 180
#: Size of the pilot sample. The 99th percentile of its pair distances is the end of the linear bins
#: of d.
PILOT_POINTS = 1000
PILOT_PERCENTILE = 99.0


@dataclass(frozen=True, kw_only=True, slots=True)
class Bins:
    """Edges of the table, limits of the slices, and the cells used for both.

    `d_edges` (D + 1,) increase, >= 0, in scene units; the last may be inf. `theta_edges_deg` (T +
    1,) increase, in [0, 180] degrees; an edge of 180 is included in the last bin. The slice over θ
    contains the pairs with d < `slice_d`, the slice over d those with θ < `slice_theta_deg`.
    `d_end` ends the evenly spaced bins of the slice over d: by default the last finite edge, or one
    bin further if the last edge is infinite. ValueError if edges do not increase, or are out of
    range.
    """

    d_edges: Floats
    theta_edges_deg: Floats
    slice_d: float = 0.2
    slice_theta_deg: float = 2.0
    d_end: float | None = None
    slice_d_edges: Floats = field(init=False)
    """(65,) edges in d of the slice θ < slice_theta_deg; the last is inf if that of d_edges is."""
    slice_theta_edges_deg: Floats = field(init=False)
    """(65,) edges in degrees of the slice d < slice_d."""
    d_cells: Floats = field(init=False)
    theta_cells: Floats = field(init=False)

    def __post_init__(self) -> None:
        d = checked_edges(self.d_edges, "d_edges")
        theta = checked_edges(self.theta_edges_deg, "theta_edges_deg")
        require(bool(np.isfinite(d[:-1]).all()), "d_edges must be finite but for the last", d)
        require(bool(theta[-1] <= 180.0), "theta_edges_deg must lie in [0, 180]", theta)
        fits = is_number(self.slice_d) and self.slice_d > 0
        require(fits, "slice_d must be a number > 0", self.slice_d)
        fits = is_number(self.slice_theta_deg) and 0 < self.slice_theta_deg <= 180
        require(fits, "slice_theta_deg must be a number in (0, 180]", self.slice_theta_deg)
        fits = self.d_end is None or (is_number(self.d_end) and 0 < self.d_end < np.inf)
        require(fits, "d_end must be a number > 0", self.d_end)
        set_ = object.__setattr__
        set_(self, "d_edges", d)
        set_(self, "theta_edges_deg", theta)
        end = self.d_end or _linear_end(d)
        over_d = np.linspace(0.0, end, N_SLICE + 1)
        if np.isinf(d[-1]):
            over_d[-1] = np.inf
        over_d, over_theta = _snap(over_d, d), _snap(np.linspace(0.0, 180.0, N_SLICE + 1), theta)
        set_(self, "slice_d_edges", over_d)
        set_(self, "slice_theta_edges_deg", over_theta)
        d_known, theta_known = np.union1d(d, over_d), np.union1d(theta, over_theta)
        set_(self, "slice_d", float(_snap(np.array([self.slice_d]), d_known)[0]))
        set_(
            self, "slice_theta_deg", float(_snap(np.array([self.slice_theta_deg]), theta_known)[0])
        )
        set_(self, "d_cells", np.union1d(d_known, [0.0, self.slice_d]))
        set_(self, "theta_cells", np.union1d(theta_known, [0.0, self.slice_theta_deg]))


def _linear_end(edges: Floats) -> float:
    """End of evenly spaced bins: the last edge, or one bin past the last finite edge."""
    if np.isfinite(edges[-1]):
        return float(edges[-1])
    if len(edges) == 2:
        return float(edges[0]) + 1.0
    return float(edges[-2] + (edges[-2] - edges[0]) / (len(edges) - 2))


def checked_edges(value: npt.ArrayLike, name: str) -> Floats:
    """Edges of bins from a list; ValueError unless they increase and are >= 0."""
    found = np.array(checked_floats(value, name, np.float64))
    fits = found.ndim == 1 and found.size >= 2 and found[0] >= 0
    fits = fits and bool((np.diff(found) > 0).all())
    require(fits, f"{name} must be at least two rising numbers >= 0", value)
    return found


def _snap(edges: Floats, known: Floats) -> Floats:
    """Replaces edges that differ from a known edge only by rounding."""
    finite = known[np.isfinite(known)]
    nearest = finite[np.abs(edges[:, None] - finite).argmin(axis=1)]
    return np.where(np.isclose(nearest, edges, rtol=1e-9, atol=0.0), nearest, edges)


def merge(cells: npt.NDArray[Any], axis: int, fine: Floats, edges: Floats) -> npt.NDArray[Any]:
    """Sums cells with the edges `fine` over bins with the edges `edges`, along one axis.

    Raises
    ------
    ValueError
        An edge is not among the fine ones.
    """
    at = np.searchsorted(fine, edges)
    known = bool((at < len(fine)).all()) and bool((fine[at] == edges).all())
    require(known, "edges must be among those of the cells", edges)
    kept = np.take(cells, range(int(at[0]), int(at[-1])), axis=axis)
    return np.add.reduceat(kept, at[:-1] - at[0], axis=axis)


def centers(edges: Floats) -> Floats:
    """Centres of bins; a last bin that ends at inf is taken as wide as the one before it."""
    closed = edges.copy()
    if np.isinf(closed[-1]):
        closed[-1] = _linear_end(edges)
    return np.asarray((closed[:-1] + closed[1:]) / 2)


def pilot_d_max(positions: npt.NDArray[np.float32], seed: int) -> float:
    """99th percentile of the distances of at most 1000 points, rounded up to 3 digits."""
    rng = np.random.Generator(np.random.Philox(key=np.array([seed, 0x9D], dtype=np.uint64)))
    chosen = rng.permutation(len(positions))[:PILOT_POINTS]
    p = positions[np.sort(chosen)].astype(np.float64)
    first, second = np.triu_indices(len(p), 1)
    step = 1 << 20  # pairs at a time, to limit memory
    parts = [
        np.sqrt(((p[first[i : i + step]] - p[second[i : i + step]]) ** 2).sum(axis=1))
        for i in range(0, len(first), step)
    ]
    distance = float(np.percentile(np.concatenate(parts), PILOT_PERCENTILE)) if parts else 0.0
    if distance <= 0.0:
        return 1.0
    digit = 10.0 ** (np.floor(np.log10(distance)) - 2)
    return float(np.ceil(distance / digit) * digit)


def linear_bins(
    d_max: float,
    n_d: int = N_D,
    n_theta: int = N_THETA,
    *,
    slice_d: float = 0.2,
    slice_theta_deg: float = 2.0,
) -> Bins:
    """Evenly spaced bins: `n_d` over [0, d_max], the last one without end, and `n_theta` over 180°.

    ValueError if d_max is not finite and > 0, or a number of bins is out of range.
    """
    require(0 < d_max < np.inf, "d_max must be finite and > 0", d_max)
    require(1 <= n_d <= 1024, "the number of d bins must be in [1, 1024]", n_d)
    require(1 <= n_theta <= 1800, "the number of theta bins must be in [1, 1800]", n_theta)
    d_edges = np.append(np.linspace(0.0, d_max, n_d + 1)[:-1], np.inf)
    theta = np.linspace(0.0, 180.0, n_theta + 1)
    return Bins(
        d_edges=d_edges,
        theta_edges_deg=theta,
        slice_d=slice_d,
        slice_theta_deg=slice_theta_deg,
        d_end=d_max,
    )

"""Chooses the limit of the exhaustive pass over near pairs when other pairs are sampled."""

from __future__ import annotations

import numpy as np

from viscache.correlation.bins import Bins
from viscache.correlation.tasks import Points

#: The near pass may count this many pairs, or this fraction of the sampled ones, whichever is more.
#: The rows of near points are scattered in memory, so a near pair costs about 30 times as much as a
#: pair of a tile.
NEAR_PAIRS = 5e6
NEAR_SHARE = 0.03
PILOT = 512


def near_limit(points: Points, bins: Bins, sampled: float, seed: int) -> float | None:
    """The largest edge below which all pairs can be counted without costing much, or None.

    Random pairs are rarely near: of 10¹⁰ pairs a few thousand may have d < 0.2. Up to this limit
    all pairs are enumerated instead. The candidates are the edges shared by the table and the slice
    over d, and `slice_d`. The number of pairs below each is estimated from a pilot of 512 points
    against all points.
    """
    from scipy.spatial import cKDTree

    n = len(points.positions)
    rng = np.random.Generator(np.random.Philox(key=np.array([seed, 0x3EA2], dtype=np.uint64)))
    pilot = points.positions[np.sort(rng.permutation(n)[:PILOT])]
    shared = np.intersect1d(bins.d_edges, bins.slice_d_edges)
    candidates = np.union1d(shared[np.isfinite(shared)], [bins.slice_d])
    candidates = candidates[candidates > 0]
    tree = cKDTree(points.positions)
    affordable = max(NEAR_PAIRS, NEAR_SHARE * sampled)
    limit = None
    for candidate in candidates:
        neighbours = tree.query_ball_point(pilot, candidate, return_length=True).mean() - 1
        if n / 2 * neighbours > affordable:
            break
        limit = float(candidate)
    return limit

"""Correlation of visibility by brute force, from Section 4 of the visibility-map paper.

Everything is written down pair by pair in float64: no tiles, no packets, no float32.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[Any]


def correlation(a: Array, b: Array) -> Array:
    """(NA, NB) Pearson's ρ of rows of bits (N, T) bool; NaN where one of them is constant."""
    t = a.shape[1]
    n11 = a.astype(np.float64) @ b.astype(np.float64).T
    na, nb = a.sum(axis=1).astype(float)[:, None], b.sum(axis=1).astype(float)[None]
    with np.errstate(invalid="ignore", divide="ignore"):
        return (t * n11 - na * nb) / np.sqrt(na * (t - na) * nb * (t - nb))


@dataclass
class Pairs:
    """All pairs i < j: indices, ρ, distance, angle in degrees."""

    i: Array
    j: Array
    rho: Array
    d: Array
    theta_deg: Array


def all_pairs(visible: Array, positions: Array, normals: Array) -> Pairs:
    """Every unordered pair of (N, T) bool rows at (N, 3) positions with (N, 3) unit normals."""
    i, j = np.triu_indices(len(visible), 1)
    p, m = positions.astype(np.float64), normals.astype(np.float64)
    apart = np.linalg.norm(m[i] - m[j], axis=1)
    together = np.linalg.norm(m[i] + m[j], axis=1)
    return Pairs(
        i=i,
        j=j,
        rho=correlation(visible, visible)[i, j],
        d=np.linalg.norm(p[i] - p[j], axis=1),
        theta_deg=np.degrees(2 * np.arctan2(apart, together)),
    )


def binned(pairs: Pairs, d_edges: Array, theta_edges_deg: Array) -> dict[str, Array]:
    """n, n_undefined, mean and sigma of half-open bins; an angle of 180° is in the last one."""
    theta = np.minimum(pairs.theta_deg, np.nextafter(180.0, 0.0))
    d_bin = np.searchsorted(d_edges, pairs.d, side="right") - 1
    t_bin = np.searchsorted(theta_edges_deg, theta, side="right") - 1
    shape = (len(d_edges) - 1, len(theta_edges_deg) - 1)
    inside = (d_bin >= 0) & (d_bin < shape[0]) & (t_bin >= 0) & (t_bin < shape[1])
    defined = inside & np.isfinite(pairs.rho)
    at = (d_bin[defined], t_bin[defined])
    n, total, square = np.zeros(shape, np.int64), np.zeros(shape), np.zeros(shape)
    np.add.at(n, at, 1)
    np.add.at(total, at, pairs.rho[defined])
    with np.errstate(invalid="ignore"):
        mean = total / n
        np.add.at(square, at, (pairs.rho[defined] - mean[at]) ** 2)
        sigma = np.sqrt(square / n)
    undefined = np.zeros(shape, np.int64)
    left = inside & ~defined
    np.add.at(undefined, (d_bin[left], t_bin[left]), 1)
    return {"n": n, "n_undefined": undefined, "mean": mean, "sigma": sigma}

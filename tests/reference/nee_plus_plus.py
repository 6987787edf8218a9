"""Next Event Estimation++ (Guo, Eisemann, Eisemann 2020) in plain NumPy: its map."""

from typing import Any

import numpy as np
import numpy.typing as npt

from reference.aqvc import octahedron

Floats = npt.NDArray[np.floating[Any]]
Whole = npt.NDArray[np.int64]


def voxel(points: Floats, low: Floats, high: Floats, n: int) -> Whole:
    """Number of the voxel of n³ over the box [low, high], x fastest; outside: the nearest."""
    p, low, high = (np.asarray(v, np.float32) for v in (points, low, high))
    size = high - low
    with np.errstate(divide="ignore", invalid="ignore"):
        scale = np.where(size > 0, np.float32(n) / size, np.float32(0))
        t = (p - low) * scale
    cell = np.clip(np.nan_to_num(t, nan=0.0, posinf=n - 1, neginf=0), 0, n - 1).astype(np.int64)
    return cell[..., 0] + n * (cell[..., 1] + n * cell[..., 2])


def direction_cell(directions: Floats, n: int) -> Whole:
    """Number of the cell of n² over the octahedral square."""
    column, row = np.clip((octahedron(directions) * n).astype(np.int64), 0, n - 1).T
    return column + n * row


def visibility(near: Whole, far: Whole, seen: npt.NDArray[np.bool_], symmetric: bool) -> Floats:
    """(seen + 1) / (tested + 1) of the pair each connection belongs to, once all are counted."""
    pairs = [(min(p), max(p)) if symmetric else p for p in zip(near, far, strict=True)]
    out = np.empty(len(pairs))
    for i, pair in enumerate(pairs):
        mine = np.array([p == pair for p in pairs])
        out[i] = (seen[mine].sum() + 1) / (mine.sum() + 1)
    return out


def probability(p: Floats, least: float, exponent: float) -> Floats:
    """Of tracing a connection."""
    return np.maximum(least, p**exponent)

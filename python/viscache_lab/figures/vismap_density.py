"""Density of records on surfaces, and its rank correlation with what should attract records."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.floating[Any]]
Cells = npt.NDArray[np.int64]


def equal_cells(positions: Floats, levels: int) -> Cells:
    """(N,) cell in [0, 2^levels) of each point.

    Each level halves the cells along their longest axis, at equal counts. Points are the pixels'
    first hits, so cells are equal parts of the picture.
    """
    cell = np.zeros(len(positions), np.int64)
    parts = [np.arange(len(positions))]
    for _ in range(levels):
        halves = []
        for part in parts:
            axis = int(np.ptp(positions[part], axis=0).argmax())
            order = part[np.argsort(positions[part, axis], kind="stable")]
            halves += [order[: len(order) // 2], order[len(order) // 2 :]]
        parts = halves
    for number, part in enumerate(parts):
        cell[part] = number
    return cell


def records_per_cell(records: Floats, positions: Floats, cell: Cells) -> Floats:
    """Number of records (R, 3) whose nearest point is in each cell."""
    from scipy.spatial import cKDTree  # type: ignore[import-untyped,unused-ignore]

    _, nearest = cKDTree(positions).query(records)
    return np.bincount(cell[nearest], minlength=int(cell.max()) + 1).astype(float)


def per_cell_mean(values: Floats, cell: Cells) -> Floats:
    """Mean of the finite values of each cell; NaN without any."""
    known = np.isfinite(values)
    n = np.bincount(cell[known], minlength=int(cell.max()) + 1)
    sums = np.bincount(cell[known], values[known], minlength=int(cell.max()) + 1)
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.asarray(sums / n)


def per_cell_angle(normals: Floats, cell: Cells) -> Floats:
    """Mean angle between a cell's normals and their sum, in degrees: a measure of curvature."""
    count = int(cell.max()) + 1
    axes = [np.bincount(cell, normals[:, k], minlength=count) for k in range(3)]
    sums: Floats = np.stack(axes, axis=-1).astype(float)
    sums = sums / np.maximum(np.linalg.norm(sums, axis=1, keepdims=True), 1e-12)
    cosine = (normals * sums[cell]).sum(axis=1)
    return per_cell_mean(np.degrees(np.arccos(np.clip(cosine, -1, 1))), cell)


def rank_correlation(a: Floats, b: Floats) -> float:
    """Spearman's coefficient of two rows of values, without entries where either is not finite."""
    from scipy.stats import spearmanr  # type: ignore[import-untyped,unused-ignore]

    known = np.isfinite(a) & np.isfinite(b)
    return float(spearmanr(a[known], b[known]).statistic)

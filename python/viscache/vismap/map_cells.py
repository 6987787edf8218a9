"""Cells of the maps, and the bits that records have there."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from viscache import _core


def cells(directions: npt.NDArray[np.float32], m: int) -> npt.NDArray[np.int64]:
    """Z-order indices (...) of the cells of unit directions (..., 3)."""
    edge = 1 << m
    at = _core.sampling.direction_to_equal_area(directions.reshape(-1, 3))
    x, y = np.minimum((at * edge).astype(np.uint32), edge - 1).T
    return np.asarray(_core.vismap.morton2(x, y), np.int64).reshape(directions.shape[:-1])


def blended_bits(
    bits: npt.NDArray[np.uint64], ids: npt.NDArray[Any], cells: npt.NDArray[np.int64]
) -> npt.NDArray[np.bool_]:
    """(N, n_best, K): the bit of each record `ids` (N, n_best) in the point's cells (N, K)."""
    rows = np.maximum(ids, 0)[:, :, None]
    at = cells[:, None, :]
    words = bits[rows, at // 64] if len(bits) else np.zeros(np.broadcast(rows, at).shape, "u8")
    found: npt.NDArray[np.bool_] = (words >> (at % 64).astype(np.uint64) & np.uint64(1)) > 0
    return found & (ids >= 0)[:, :, None]

"""Resolutions, keys and hashes of the quantized cache, as the C++ core computes them."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from viscache import _core
from viscache.settings.visibility import Aqvc

__all__ = ["eye_keys", "hash_keys", "level_hashes", "resolution_eye"]

#: Numbers of a whole key, and those of its eye side, which come first.
KEY, EYE_KEY = 15, 8


def resolution_eye(
    density: npt.ArrayLike, c_e: npt.ArrayLike, radius: npt.ArrayLike
) -> npt.NDArray[np.float64]:
    """R_e of Eq. 7: cells along the scene's diameter, before they are rounded to a level.

    Parameters
    ----------
    density : (N,) float
        Eye paths per unit of area.
    c_e : (N,) float
    radius : (N,) float
        Of the scene's bounding sphere.
    """
    return np.asarray(_core.aqvc.resolution_eye(density, c_e, radius), float)


def eye_keys(
    settings: Aqvc,
    center: tuple[float, float, float],
    radius: float,
    points: npt.NDArray[np.float32],
    normals: npt.NDArray[np.float32],
    resolutions: npt.NDArray[np.float64],
) -> tuple[npt.NDArray[np.int32], npt.NDArray[np.bool_]]:
    """The eye side of cluster keys (Eq. 4, Sec. 3.3).

    Parameters
    ----------
    settings : Aqvc
    center, radius : (3,) float, float
        The scene's bounding sphere.
    points, normals : (N, 3) float
    resolutions : (N,) float
        Cells along the scene's diameter, as from `resolution_eye`.

    Returns
    -------
    keys : (N, 8) int32
        Points with equal keys are in one cell.
    valid : (N,) bool
        False where a point has no cell.
    """
    far = np.zeros((len(points), 3), np.float32)
    keys, _, valid, _ = _core.aqvc.full_keys(
        settings.core(), center, radius, points, normals, resolutions,
        0, far, far, np.ones(len(points)),
    )  # fmt: skip
    return np.asarray(keys[:, :EYE_KEY]), np.asarray(valid, bool)


def hash_keys(keys: npt.NDArray[np.int32]) -> npt.NDArray[np.uint32]:
    """κ and c of Eq. 10, (N, 2), of keys (N, K); numbers that a key lacks are 0."""
    whole = np.zeros((len(keys), KEY), np.int32)
    whole[:, : keys.shape[1]] = keys
    return _core.aqvc.hash_keys(whole)


def level_hashes(settings: Aqvc, *arrays: Any, at_once: bool) -> tuple[Any, ...]:
    """The hashes of four levels and their CPU seconds, for `viscache bench aqvc-lookup`."""
    return _core.aqvc.level_hashes(settings.core(), *arrays, at_once=at_once)

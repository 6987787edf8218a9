"""Resolutions, keys and hashes of the quantized cache, as the C++ core computes them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from viscache import _core
from viscache.settings.checks import checked_floats, is_number, require
from viscache.settings.visibility import Aqvc

#: Numbers of a whole key, and those of its eye side, which come first.
KEY, EYE_KEY = 15, 8


def resolution_eye(
    density: npt.ArrayLike, c_e: npt.ArrayLike, radius: npt.ArrayLike
) -> npt.NDArray[np.float64]:
    """R_e of Eq. 7: cells along the scene's diameter, before they are rounded to a level.

    Parameters
    ----------
    density : (...) float
        Eye paths per unit of area.
    c_e : (...) float
    radius : (...) float
        Of the scene's bounding sphere.

    Raises
    ------
    ValueError
        An argument does not hold numbers, or their shapes do not match.
    """
    given = {"density": density, "c_e": c_e, "radius": radius}
    numbers = [checked_floats(values, name, np.float64) for name, values in given.items()]
    return np.asarray(_core.aqvc.resolution_eye(*np.broadcast_arrays(*numbers)), float)


def eye_keys(
    settings: Aqvc,
    center: Sequence[float],
    radius: float,
    points: npt.ArrayLike,
    normals: npt.ArrayLike,
    resolutions: npt.ArrayLike,
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

    Raises
    ------
    ValueError
        An argument has another type or shape.
    """
    require(isinstance(settings, Aqvc), "settings must be vc.Aqvc(...)", settings)
    middle = checked_floats(center, "center", np.float64)
    require(middle.shape == (3,), "center must have shape (3,)", middle.shape)
    require(is_number(radius) and 0 < radius < math.inf, "radius must be in (0, inf)", radius)
    places, sides = checked_floats(points, "points"), checked_floats(normals, "normals")
    sizes = checked_floats(resolutions, "resolutions", np.float64)
    fits = places.ndim == 2 and places.shape[1] == 3
    require(fits, "points must have shape (N, 3)", places.shape)
    require(sides.shape == places.shape, f"normals must have shape {places.shape}", sides.shape)
    count = len(places)
    require(sizes.shape == (count,), f"resolutions must have shape ({count},)", sizes.shape)
    far = np.zeros_like(places)
    keys, _, valid, _ = _core.aqvc.full_keys(
        settings.core(), middle.tolist(), float(radius), places, sides, sizes,
        0, far, far, np.ones(count),
    )  # fmt: skip
    return np.asarray(keys[:, :EYE_KEY]), np.asarray(valid, bool)


def hash_keys(keys: npt.ArrayLike) -> npt.NDArray[np.uint32]:
    """κ and c of Eq. 10.

    Parameters
    ----------
    keys : (N, K) int32, K <= 15
        As from `eye_keys`; numbers that a key lacks are 0.

    Returns
    -------
    (N, 2) uint32

    Raises
    ------
    ValueError
        `keys` has another type or shape.
    """
    given = np.asarray(keys)
    require(given.dtype == np.int32, "keys must be int32", given.dtype)
    require(given.ndim == 2 and given.shape[1] <= KEY, f"keys must be (N, 0..{KEY})", given.shape)
    whole = np.zeros((len(given), KEY), np.int32)
    whole[:, : given.shape[1]] = given
    return _core.aqvc.hash_keys(whole)


def level_hashes(settings: Aqvc, *arrays: Any, at_once: bool) -> tuple[Any, ...]:
    """The hashes of four levels and their CPU seconds, for `viscache bench aqvc-lookup`."""
    return _core.aqvc.level_hashes(settings.core(), *arrays, at_once=at_once)

"""The directions of the visibility field: unsigned axes distributed over the hemisphere."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from viscache import _core
from viscache.settings.checks import checked_points, is_whole, require

#: Allowed values of n_directions: 1, and 2·4^k + 1.
DIRECTION_COUNTS = (1, 3, 9, 33, 129, 513, 2049, 8193)


def checked_directions(n_directions: Any) -> int:
    """n_directions as an int; ValueError if it is not one of DIRECTION_COUNTS."""
    counts = ", ".join(map(str, DIRECTION_COUNTS))
    holds = is_whole(n_directions) and int(n_directions) in DIRECTION_COUNTS
    require(holds, f"n_directions must be one of {counts} (2·4^k + 1)", n_directions)
    return int(n_directions)


def directions(n_directions: int = 513) -> npt.NDArray[np.float32]:
    """The axes Ω_l (VLF Sec. 3.1): a subdivided half octahedron.

    Parameters
    ----------
    n_directions : int
        l: 1, 3, 9, 33, 129, 513, 2049 or 8193.

    Returns
    -------
    (l, 3) float32
        Unit vectors with z >= 0; of a direction on the equator and its opposite only one. An axis
        has no sign: for any normal, one of its two directions points into the hemisphere.

    Raises
    ------
    ValueError
        The number is not allowed.

    Examples
    --------
    >>> import viscache as vc
    >>> vc.vlf.directions(513).shape
    (513, 3)
    """
    return _core.vlf.directions(checked_directions(n_directions))


def direction_frames(n_directions: int = 513) -> npt.NDArray[np.float32]:
    """Rotations into the canonical spaces of the axes.

    Returns
    -------
    (l, 3, 3) float32
        Rows u, v, w of a right-handed orthonormal frame; w is the axis. ``frames[k] @ p`` are the
        canonical coordinates of p.
    """
    return _core.vlf.direction_frames(checked_directions(n_directions))


def direction_weights(n_directions: int = 513) -> npt.NDArray[np.float32]:
    """Solid angles of the cells of the axes: spherical Voronoi areas.

    Returns
    -------
    (l,) float32
        In sr; the sum is 2π. The paper weights all axes equally, which biases sums over the
        hemisphere: at l = 513 the cells have 0.79 to 1.60 times their mean.
    """
    return _core.vlf.direction_weights(checked_directions(n_directions))


def nearest_direction(d: npt.ArrayLike, n_directions: int = 513) -> npt.NDArray[np.int64]:
    """The axis with the smallest angle to a direction or its opposite; exact, in constant time.

    Parameters
    ----------
    d : (N, 3) float
        Of any length except 0.
    n_directions : int
        l.

    Returns
    -------
    (N,) int64
        Indices into `directions`; of equally near ones the lowest.

    Raises
    ------
    ValueError
        A direction is zero or not finite.
    """
    count = checked_directions(n_directions)
    nearest = _core.vlf.nearest_direction(checked_points(d, "d"), count)
    return nearest.astype(np.int64)

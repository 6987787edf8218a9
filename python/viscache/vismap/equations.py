"""Equations of the visibility maps on arrays."""

from __future__ import annotations

from typing import Any

import numpy.typing as npt

from viscache import _core


def record_weight(t: npt.ArrayLike, theta: npt.ArrayLike, steepness: npt.ArrayLike) -> Any:
    """The weight w of a record (Eq. 9): a float, or an array where an argument is one.

    Parameters
    ----------
    t : (...) float
        Distance, in units of d_max.
    theta : (...) float
        Angle between the normals, in radians.
    steepness : (...) float
        λ.
    """
    return _core.vismap.record_weight(t, theta, steepness)

"""Arrays of numbers that must be real: NumPy drops imaginary parts with a warning alone."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt


def real_array(values: npt.ArrayLike, name: str) -> npt.NDArray[Any]:
    """The values as an array of their own type; ValueError where one is complex."""
    array = np.asarray(values)
    kind = array.dtype.kind
    if kind == "c" or (kind == "O" and any(np.iscomplexobj(value) for value in array.flat)):
        raise ValueError(f"{name} must be real numbers, got dtype {array.dtype}")
    return array

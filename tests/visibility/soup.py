"""Triangles and rays without order, for the tests of casters."""

from typing import Any

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[Any]


def soup(n: int = 200, size: float = 0.5, seed: int = 0) -> tuple[Array, Array]:
    """Vertices and triangles, about the cube [-1, 1]^3."""
    r = np.random.default_rng(seed)
    corners = r.uniform(-1, 1, (n, 1, 3)) + r.normal(0, size, (n, 3, 3))
    return corners.reshape(-1, 3).astype(np.float32), np.arange(3 * n, dtype="u4").reshape(-1, 3)


def rays(n: int, seed: int = 1, *, along: bool = False) -> tuple[Array, Array]:
    """Some begin inside; if `along`, a third is parallel to an axis, and another to two."""
    r = np.random.default_rng(seed)
    o, d = r.uniform(-2, 2, (n, 3)), r.normal(size=(n, 3))
    if along:
        rows = np.arange(n)
        d[rows % 3 == 1, r.integers(0, 3)] = 0
        axis = np.flatnonzero(rows % 3 == 0)
        d[axis] = np.eye(3)[r.integers(0, 3, len(axis))] * r.choice([-1, 1], (len(axis), 1))
    return o.astype(np.float32), d.astype(np.float32)

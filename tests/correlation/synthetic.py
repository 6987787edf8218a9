"""Small problems whose pairs can be written down one by one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from reference import vismap


@dataclass(frozen=True)
class Problem:
    """Rows of bits and the points they belong to."""

    visible: npt.NDArray[np.bool_]
    positions: npt.NDArray[np.float32]
    normals: npt.NDArray[np.float32]

    @property
    def bits(self) -> npt.NDArray[np.uint64]:
        return vismap.packed(self.visible)


def bumpy(n: int, n_directions: int = 500, seed: int = 0) -> Problem:
    """A bumpy patch of 4×4 units; a point sees what is above it, less a random blob of sky."""
    rng = np.random.default_rng(seed)
    directions = _sphere(rng, n_directions)
    positions = np.column_stack([rng.uniform(0, 4, (n, 2)), rng.normal(0, 0.05, n)])
    normals = np.column_stack([rng.normal(0, 0.5, (n, 2)), np.ones(n)])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    blob = np.array([np.cos(positions[:, 0]), np.sin(positions[:, 1]), np.full(n, 0.4)]).T
    visible = (normals @ directions.T > 0) & (blob @ directions.T < 0.6)
    visible[::17] = False  # some points see nothing at all
    return Problem(visible, positions.astype(np.float32), normals.astype(np.float32))


def half_spaces(n: int, map_size: int = 96, seed: int = 0) -> Problem:
    """Points of a convex body: they see the whole hemisphere above them."""
    rng = np.random.default_rng(seed)
    normals = _sphere(rng, n).astype(np.float32)
    directions = vismap.equal_area_directions(map_size)
    return Problem(normals @ directions.T > 0, normals, normals)


def _sphere(rng: np.random.Generator, n: int) -> npt.NDArray[np.float64]:
    v = rng.normal(size=(n, 3))
    return np.asarray(v / np.linalg.norm(v, axis=1, keepdims=True))

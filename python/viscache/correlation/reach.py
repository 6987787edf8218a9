"""The length of rays in a closed scene, where no ray reaches the sky."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

#: Points of the pilot, and directions over the whole sphere.
PILOT_POINTS, PILOT_DIRECTIONS = 256, 128
#: The pilot's rays start this share of the scene's diagonal above the surface.
OFFSET = 1e-4


def closed_reach(
    scene: Any,
    positions: npt.NDArray[np.float32],
    normals: npt.NDArray[np.float32],
    threads: int | None = None,
) -> float:
    """A distance within which visibility varies, for points (N, 3) of a closed scene; else inf.

    A scene is closed if at least half of the pilot's points see no sky. There the length is the
    median of the free paths above the surfaces, rounded up to two digits, so about half of all
    directions are free: rows of bits have most to tell.
    """
    chosen = np.unique(np.linspace(0, len(positions) - 1, PILOT_POINTS).astype(int))
    up = normals[chosen].astype(float)
    lift = OFFSET * float(np.linalg.norm(scene.bounds[1] - scene.bounds[0]))
    origins = positions[chosen] + lift * up
    directions = _even_directions(PILOT_DIRECTIONS)
    found = scene.intersect(origins[:, None, :], directions[None, :, :], threads=threads)
    free = np.asarray(found.t, dtype=float) + lift
    above = up @ directions.T > 0
    sees_sky = (above & ~np.isfinite(free)).any(axis=1)
    if sees_sky.mean() > 0.5:
        return float(np.inf)
    length = float(np.median(free[above]))
    digit = 10.0 ** (np.floor(np.log10(length)) - 1)
    return float(np.ceil(length / digit) * digit)


def _even_directions(count: int) -> npt.NDArray[np.float64]:
    """A spherical Fibonacci set."""
    k = np.arange(count)
    z = 1 - (2 * k + 1) / count
    angle = k * np.pi * (3 - np.sqrt(5))
    r = np.sqrt(1 - z * z)
    return np.column_stack([r * np.cos(angle), r * np.sin(angle), z])

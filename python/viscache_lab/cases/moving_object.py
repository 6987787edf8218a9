"""An object that moves through a scene: a ball with a given number of triangles."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
import numpy.typing as npt

import viscache as vc

Mesh: TypeAlias = tuple[npt.NDArray[np.float64], npt.NDArray[np.int64]]

RADIUS = 0.12
#: The object's places, in order.
STOPS = ((0.3, 0.5, 0.2), (-0.4, 0.4, -0.3), (0.1, 0.3, 0.5), (-0.2, 0.6, 0.1))


def ball(triangles: int, center: tuple[float, float, float]) -> Mesh:
    """A sphere with about this many triangles."""
    rings = max(3, round(0.5 + (0.25 + triangles / 4) ** 0.5))
    sectors = 2 * rings
    theta = np.pi * np.arange(rings + 1) / rings
    phi = 2 * np.pi * np.arange(sectors) / sectors
    ring = np.sin(theta)[:, None]
    p = np.stack([ring * np.cos(phi), np.cos(theta)[:, None] + 0 * phi, ring * np.sin(phi)], -1)
    i, j = np.meshgrid(np.arange(rings), np.arange(sectors), indexing="ij")
    a, b = i * sectors + j, i * sectors + (j + 1) % sectors
    below = a + sectors
    quads = np.stack([np.stack([a, b, below], -1), np.stack([below, b, b + sectors], -1)])
    # At the poles one of the two triangles has no area
    keep = np.concatenate([(i > 0).ravel(), (i < rings - 1).ravel()])
    return RADIUS * p.reshape(-1, 3) + center, quads.reshape(-1, 3)[keep]


def with_object(
    scene: vc.Scene, vertices: npt.NDArray[np.float64], triangles: npt.NDArray[np.int64]
) -> vc.Scene:
    """The scene's triangles and the object's."""
    parts = [(m["vertices"], m["triangles"]) for m in scene.meshes()]
    return vc.Scene.from_arrays([*parts, (vertices, triangles)])

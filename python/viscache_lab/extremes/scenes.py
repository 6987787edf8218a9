"""Small scenes of the checks, made once per process."""

from __future__ import annotations

from functools import cache

import numpy as np
import numpy.typing as npt

import viscache as vc
from viscache_lab.extremes.moved import description_of

#: Vertices (V, 3) and triangles (T, 3).
Arrays = tuple[npt.NDArray[np.float64], npt.NDArray[np.uint32]]
_QUAD = np.array([[0, 1, 2], [0, 2, 3]], np.uint32)


@cache
def lit_box() -> vc.Scene:
    """The Cornell box with its area light, a point light and a sun through the open side."""
    description = description_of(vc.scenes.cornell_box())
    description.add_point_light((-0.15, 0.5, -0.1), (0.4, 0.4, 0.4))
    description.add_directional_light((0.3, 0.3, 1.0), (1.5, 1.4, 1.2))
    return vc.Scene.from_description(description)


@cache
def cube() -> vc.Scene:
    """The cube on a plane under a point light: hard shadows."""
    made: vc.Scene = vc.scenes.cube_on_plane()
    return made


@cache
def sky() -> npt.NDArray[np.float32]:
    """A small sky (8, 16, 3), brighter towards one corner."""
    return np.linspace(0.2, 2, 8 * 16 * 3, dtype=np.float32).reshape(8, 16, 3)


def floor(width: float = 4.0, height: float = 0.0) -> Arrays:
    """A square in the plane y = height."""
    w = width
    corners = [[-w, height, w], [w, height, w], [w, height, -w], [-w, height, -w]]
    return np.array(corners), _QUAD


def table() -> Arrays:
    """A square above the floor."""
    return floor(0.5, 0.6)


def described(
    *parts: Arrays,
    lights: tuple[tuple[tuple[float, float, float], float], ...] = (((2.2, 3.0, 1.2), 12.0),),
    camera: tuple[tuple[float, float, float], tuple[float, float, float], float] = (
        (-1.2, 2.6, 4.2),
        (0.0, 0.35, 0.0),
        38.0,
    ),
) -> vc.SceneDescription:
    """Grey two-sided meshes, point lights (place, intensity) and a camera (from, to, fov)."""
    description = vc.SceneDescription()
    grey = description.add_material(base_color=(0.5, 0.5, 0.5))
    for vertices, triangles in parts:
        description.add_mesh(vertices, triangles, material=grey)
    for place, intensity in lights:
        description.add_point_light(place, (intensity,) * 3)
    description.add_camera(camera[0], camera[1], fov_deg=camera[2])
    return description


def with_parts(*parts: Arrays, **more: object) -> vc.Scene:
    """The scene of `described`."""
    return vc.Scene.from_description(described(*parts, **more))  # type: ignore[arg-type]


def closed_box(n: int) -> Arrays:
    """The surface of [-1, 1]³, n × n squares on each side, with shared vertices."""
    steps = np.linspace(-1, 1, n + 1)
    corners: list[npt.NDArray[np.float64]] = []
    triangles: list[npt.NDArray[np.int64]] = []
    for axis in range(3):
        for side in (-1.0, 1.0):
            u, v = np.meshgrid(steps, steps, indexing="ij")
            face = np.empty((n + 1, n + 1, 3))
            face[..., axis], face[..., (axis + 1) % 3], face[..., (axis + 2) % 3] = side, u, v
            first = sum(map(len, corners))
            corners.append(face.reshape(-1, 3))
            a = first + (np.arange(n)[:, None] * (n + 1) + np.arange(n)).ravel()
            b, c, d = a + n + 1, a + n + 2, a + 1
            triangles += [np.stack([a, b, c], 1), np.stack([a, c, d], 1)]
    every: npt.NDArray[np.float64] = np.round(np.concatenate(corners), 9).astype(np.float64)
    points, index = np.unique(every, axis=0, return_inverse=True)
    return points, index.reshape(-1)[np.concatenate(triangles)].astype(np.uint32)


def sphere(n: int, flat: float = 1.0) -> Arrays:
    """The box's surface on the unit sphere; `flat` scales its y."""
    points, triangles = closed_box(n)
    points = points / np.linalg.norm(points, axis=1, keepdims=True)
    return points * [1.0, flat, 1.0], triangles

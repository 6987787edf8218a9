"""The hairball: thousands of curled strands, the hardest occluder for any cache."""

from __future__ import annotations

from typing import Annotated

import numpy as np
import numpy.typing as npt

from viscache.scenes.builder import Builder
from viscache.scenes.registry import MOST_TRIANGLES, Range, scene
from viscache.scenes.shapes import Array

SEED = 77
SIDES = 3
FULL = 3_000_000
RADIUS, ROOT_RADIUS = 0.5, 0.16  # metres
THICKNESS = 0.0012


@scene()
def hairball(triangles: Annotated[int, Range(100, MOST_TRIANGLES)] = FULL) -> Builder:
    """Ball of curled three-sided strands, 1 m wide, under a lamp and a sky.

    Parameters
    ----------
    triangles : int
        Placed triangles; the scene has this many to 1.25 times as many. At least 100.
    """
    segments = int(np.clip(round(100 * (triangles / FULL) ** (1 / 3)), 4, 100))
    strands = -(-triangles // (2 * SIDES * segments))
    # Fewer strands are thicker, so that the ball stays about as dense.
    thickness = THICKNESS * max(1.0, (5000 / strands) ** 0.5)
    b = Builder("hairball")
    path, axis = _paths(strands, segments)
    vertices = _skin(path, axis, thickness)
    material = b.diffuse("hair", (0.42, 0.26, 0.14))
    b.add_mesh(vertices, _strips(strands, segments), material, name="hair")
    b.point_light((1.2, 1.6, 1.4), 5.0)
    b.description.set_environment((0.5, 0.6, 0.75))
    b.camera((0.0, 0.25, 1.75), (0.0, 0.0, 0.0), 38.0, size=(512, 512))
    return b


def _paths(strands: int, segments: int) -> tuple[Array, Array]:
    """Points (S, segments + 1, 3) of the strands, and the axis (S, 3) each turns around."""
    rng = np.random.Generator(np.random.Philox(SEED))
    k = np.arange(strands) + 0.5
    z = 1 - 2 * k / strands
    turn = k * np.pi * (1 + 5**0.5)
    r = np.sqrt(1 - z * z)
    root = np.stack([r * np.cos(turn), z, r * np.sin(turn)], axis=1)
    axis = np.cross(root, _unit(rng.normal(size=(strands, 3))))
    axis = _unit(axis + 0.35 * root * rng.normal(size=(strands, 1)))
    side = np.cross(axis, root)
    t = np.linspace(0, 1, segments + 1)
    sweep = rng.uniform(0.8, 4.5, (strands, 1)) * t**1.3
    wobble = rng.uniform(0.1, 0.5, (strands, 1)) * np.sin(
        rng.uniform(4, 11, (strands, 1)) * t + rng.uniform(0, 6.28, (strands, 1))
    )
    angle = (sweep + wobble * t)[..., None]
    along = np.sum(axis * root, axis=1)[:, None, None] * axis[:, None]
    turned = (root[:, None] - along) * np.cos(angle) + side[:, None] * np.sin(angle) + along
    lift = 0.25 * np.sin(rng.uniform(3, 9, (strands, 1)) * t)[..., None] * t[:, None]
    direction = _unit(turned + lift * axis[:, None])
    reach = rng.uniform(0.55, 1.0, (strands, 1)) ** 0.6
    radius = ROOT_RADIUS + (RADIUS * reach - ROOT_RADIUS) * np.sin(0.5 * np.pi * t) ** 0.9
    return direction * radius[..., None], axis


def _skin(path: Array, axis: Array, thickness: float) -> npt.NDArray[np.float32]:
    """Three-sided, slightly twisted tubes around the paths: (S * (segments + 1) * 3, 3)."""
    tangent = _unit(np.gradient(path, axis=1))
    side = _unit(np.cross(tangent, axis[:, None] + 1e-3))
    other = np.cross(tangent, side)
    rows = path.shape[1]
    taper = thickness * (1 - 0.7 * np.linspace(0, 1, rows) ** 2)[:, None]
    out = np.empty((*path.shape[:2], SIDES, 3), np.float32)
    for k in range(SIDES):
        twist = (2 * np.pi * k / SIDES + 0.23 * np.arange(rows))[:, None]
        out[:, :, k] = path + taper * (np.cos(twist) * side + np.sin(twist) * other)
    return out.reshape(-1, 3)


def _strips(strands: int, segments: int) -> npt.NDArray[np.uint32]:
    row = np.arange(segments, dtype=np.uint32)[:, None] * SIDES
    k = np.arange(SIDES, dtype=np.uint32)
    a, b = row + k, row + (k + 1) % SIDES
    quads = np.stack([a, b, a + SIDES, b, b + SIDES, a + SIDES], axis=-1).reshape(-1, 3)
    starts = np.arange(strands, dtype=np.uint32)[:, None, None] * ((segments + 1) * SIDES)
    return (quads[None] + starts).reshape(-1, 3)


def _unit(v: Array) -> Array:
    out: Array = v / np.maximum(np.linalg.norm(v, axis=-1, keepdims=True), 1e-12)
    return out

"""Depths along an axis that rounding would turn are decided in double."""

from __future__ import annotations

import numpy as np

import viscache as vc
from vlf.aligned_scenes import batch, embree, frames_of, surface, unexcused


def slivers(n: int = 200) -> vc.Scene:
    """Fans of triangles a thousand times longer than wide, in many planes."""
    random = np.random.default_rng(8)
    tip = random.uniform(-1, 1, (n, 3))
    along, side = random.normal(size=(2, n, 3))
    along /= np.linalg.norm(along, axis=1)[:, None]
    side -= (side * along).sum(1)[:, None] * along
    side *= (1e-3 / np.linalg.norm(side, axis=1))[:, None]
    vertices = np.stack([tip, tip + along, tip + along + side], 1).reshape(-1, 3)
    triangles = np.arange(3 * n).reshape(n, 3)
    return vc.Scene.from_arrays(vertices.astype(np.float32), triangles.astype(np.uint32))


def test_slivers_do_not_block_rays_that_start_on_them() -> None:
    scene, frames = slivers(), frames_of(129)
    points, normals = surface(scene, 3000)
    ours = batch(scene, points, normals, frames)
    theirs = embree(scene, points, normals, frames)
    assert unexcused(scene, points, normals, frames, ours, theirs)[1] == 0
    short = batch(scene, points, normals, frames, t_max=0.3)
    limited = embree(scene, points, normals, frames, t_max=0.3)
    assert unexcused(scene, points, normals, frames, short, limited, 0.3)[1] == 0

"""What the tests of aligned rays share: points, unpacked rows, comparison with Embree."""

from typing import Any

import numpy as np
import numpy.typing as npt

import viscache as vc
from core import testing
from reference.vlf_aligned import excused, origins
from viscache import _core

Array = npt.NDArray[Any]


def frames_of(n_directions: int, some: int | None = None) -> Array:
    frames = _core.vlf.direction_frames(n_directions)
    if some is None or some >= len(frames):
        return frames
    return np.ascontiguousarray(frames[np.linspace(0, len(frames) - 1, some).astype(int)])


def batch(scene: vc.Scene, points: Array, normals: Array, frames: Array, **more) -> Array:
    """(N, l) bool by the batch."""
    bits, _ = scene.aligned_batch().rows(scene._core, points, normals, frames, **more)
    return unpacked(bits, len(frames))


def embree(scene: vc.Scene, points: Array, normals: Array, frames: Array, **more) -> Array:
    bits = _core.vlf.embree_rows(scene.caster(), points, normals, frames, **more)
    return unpacked(bits, len(frames))


def unpacked(bits: Array, n_directions: int) -> Array:
    """Rows of bits as booleans; padding must be 0."""
    assert bits.shape[1] == -(-n_directions // 64)
    k = np.arange(64 * bits.shape[1])
    all_bits = (bits[:, k // 64] >> (k % 64).astype(np.uint64) & np.uint64(1)).astype(bool)
    assert not all_bits[:, n_directions:].any()
    return all_bits[:, :n_directions]


def surface(scene: vc.Scene, n: int, seed: int = 0) -> tuple[Array, Array]:
    """Points all over the surfaces, looking to either side."""
    at = vc.correlation.surface_points(scene, max(n, 16), points="area", seed=seed)
    side = np.where(np.random.default_rng(seed).random(len(at.positions)) < 0.5, 1, -1)
    normals = (at.normals * side[:, None]).astype(np.float32)
    return at.positions[:n], normals[:n]


def unexcused(
    scene: vc.Scene,
    points: Array,
    normals: Array,
    frames: Array,
    a: Array,
    b: Array,
    t_max: float = np.inf,
) -> tuple[int, int]:
    """Rays answered differently, and those of them that rounding does not explain."""
    differing = np.argwhere(a != b)
    if not len(differing):
        return 0, 0
    flat = testing.flat_triangles(scene._core)
    triangles, o = flat["corners"], origins(scene, points, normals)
    size = float(np.linalg.norm(np.ptp(triangles.reshape(-1, 3), axis=0))) / 2

    def masks(numbers: Array, uv: Array) -> Array:
        return testing.solid_at(
            scene._core, flat["mesh"][numbers], flat["triangle"][numbers], uv.astype(np.float32)
        )

    bad = 0
    for i, k in differing:
        w = frames[k, 2]
        side = 1 if w[0] * normals[i, 0] + w[1] * normals[i, 1] + w[2] * normals[i, 2] >= 0 else -1
        bad += not excused(triangles, o[i], side * w, 1e-6 * size, t_max, masks)
    return len(differing), bad

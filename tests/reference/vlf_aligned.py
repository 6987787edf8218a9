"""Aligned rays one by one: a plain transcription of what one ray along an axis hits, in NumPy.

Every triangle is tried for every ray; the batch must give the same bits. And an oracle in double
that says which answers rounding may turn.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

import viscache as vc

Array = npt.NDArray[Any]
f32 = np.float32


def corners(scene: vc.Scene) -> Array:
    """Triangles of the world's meshes (T, 3, 3) float32, without area left out."""
    parts = [
        np.asarray(m["vertices"], f32)[np.asarray(m["triangles"])]
        for m in scene.meshes()
        if m["in_world"] and len(m["triangles"])
    ]
    if not parts:
        return np.zeros((0, 3, 3), f32)
    all_of_them = np.concatenate(parts)
    a, b, c = (all_of_them[:, i].astype(float) for i in range(3))
    return all_of_them[np.linalg.norm(np.cross(b - a, c - a), axis=1) > 0]


def origins(scene: vc.Scene, points: Array, normals: Array) -> Array:
    """Where rays start (visibility/query.h): 8 units in the last place off the surface."""
    extent = f32(scene._core.offset_extent)
    size = np.maximum(np.abs(points).max(1), extent)
    step = f32(8) * f32(2.0**-23) * size
    return np.asarray(points + normals * step[:, None], f32)


def placement(triangles: Array) -> tuple[Array, np.float32]:
    """Centre and power of two that bring the scene to a radius of about one."""
    lo, hi = triangles.min((0, 1)), triangles.max((0, 1))
    d = hi - lo
    radius = f32(0.5) * np.sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2])
    return (lo + hi) * f32(0.5), f32(2.0) ** f32(-(np.floor(np.log2(float(radius))) + 1))


def along(row: Array, p: Array) -> Array:
    """row·p, term by term."""
    return row[0] * p[..., 0] + row[1] * p[..., 1] + row[2] * p[..., 2]


def free_along(
    triangles: Array, o: Array, normals: Array, frames: Array, t_max: float = np.inf
) -> Array:
    """(N, l) bool: is the ray of each origin along each axis free?"""
    free = np.ones((len(o), len(frames)), bool)
    if not len(triangles):
        return free
    centre, scale = placement(triangles)
    v, p = (triangles - centre) * scale, (o - centre) * scale
    for k, frame in enumerate(frames):
        up = along(frame[2], normals) >= 0
        corner = [along(row, v) for row in frame]  # x, y, z of (T, 3)
        point = [along(row, p) for row in frame]
        for i in range(len(o)):
            x, y, z = (c - q[i] for c, q in zip(corner, point, strict=True))
            free[i, k] = not blocked(x, y, z, bool(up[i]), f32(t_max) * scale)
    return free


def blocked(x: Array, y: Array, z: Array, up: bool, reach: np.float32) -> bool:
    """Corners (T, 3) float32 relative to the point: does any triangle block? In double."""
    edge, det, t = functions(*(c.astype(float) for c in (x, y, z)))
    return bool(decided(edge, det, t, up, float(reach)).any())


def functions(x: Array, y: Array, z: Array) -> tuple[Array, Array, Array]:
    """Edge functions, their sum, and depth times that sum."""
    pairs = ((1, 2), (2, 0), (0, 1))
    edge = np.stack([x[:, i] * y[:, j] - y[:, i] * x[:, j] for i, j in pairs], 1)
    det = edge[:, 0] + edge[:, 1] + edge[:, 2]
    return edge, det, edge[:, 0] * z[:, 0] + edge[:, 1] * z[:, 1] + edge[:, 2] * z[:, 2]


def decided(edge: Array, det: Array, t: Array, up: bool, reach) -> Array:
    left, right = (edge >= 0).all(1), (edge <= 0).all(1)
    farther = np.where(left == up, t > 0, t < 0)
    hit: Array = (left != right) & farther
    if np.isfinite(reach):
        hit &= np.abs(t) <= reach * np.abs(det)
    return hit


def excused(
    triangles: Array,
    o: Array,
    d: Array,
    tolerance: float,
    t_max: float = np.inf,
    masks: Callable[[Array, Array], Array] | None = None,
) -> bool:
    """May rounding turn the answer of this ray?

    In double: no triangle blocks it by more than `tolerance`, and one would if larger by it. What
    `masks(numbers, (u, v))` does not call solid is no triangle there; what it calls so at some
    barycentrics within rounding, and not at others, may be one.
    """
    n = d.astype(float) / np.linalg.norm(d.astype(float))
    u = np.cross(n, [1.0, 0, 0] if abs(n[0]) < 0.5 else [0, 1.0, 0])
    u /= np.linalg.norm(u)
    v = np.cross(n, u)
    p = triangles.astype(float) - o.astype(float)
    x, y, z = p @ u, p @ v, p @ n
    edge, det, t = functions(x, y, z)
    sign = np.where(det < 0, -1.0, 1.0)
    j, k = [1, 2, 0], [2, 0, 1]
    length = np.hypot(x[:, j] - x[:, k], y[:, j] - y[:, k])
    inside = (edge * sign[:, None] / np.maximum(length, 1e-300)).min(1)
    with np.errstate(divide="ignore", invalid="ignore"):
        depth = t / det
        uv = edge[:, 1:] / det[:, None]
    # Seen so flatly that its depth hangs on the last digits
    thin = np.abs(det) < tolerance * length.max(1)
    surely = ~thin & (inside > tolerance) & (depth > tolerance) & (depth < t_max - tolerance)
    near_z = (z.max(1) > -tolerance) & (z.min(1) < t_max + tolerance)
    maybe = thin | ((depth > -tolerance) & (depth < t_max + tolerance))
    close = (inside > -tolerance) | (thin & (np.hypot(x, y).min(1) < length.max(1) + tolerance))
    if masks is None:
        return bool(not surely.any() and (close & maybe & near_z).any())
    some = np.flatnonzero(close & maybe & near_z)
    # Barycentrics are edge / det: seen flatly, they hang on digits more than seen from the front
    moved = tolerance * length[some].max(1) / np.maximum(np.abs(det[some]), 1e-300)
    always, ever = mask_at(masks, some, uv[some], np.minimum(moved, 1))
    return bool(not (surely[some] & always).any() and ever.any())


def mask_at(
    masks: Callable[[Array, Array], Array], numbers: Array, uv: Array, radius: Array
) -> tuple[Array, Array]:
    """Are triangles solid all around (u, v), and anywhere there? Within `radius`, at 25 places."""
    steps = np.linspace(-1, 1, 5)
    offsets = np.stack(np.meshgrid(steps, steps), -1).reshape(-1, 2)
    around = (
        np.clip(np.nan_to_num(uv), -2, 2)[:, None]
        + offsets * np.maximum(radius, 1e-6)[:, None, None]
    )
    solid = masks(np.repeat(numbers, len(offsets)), around.reshape(-1, 2))
    solid = solid.reshape(len(numbers), len(offsets))
    return solid.all(1), solid.any(1)

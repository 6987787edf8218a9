"""Scenes and rays for the visibility field, and a judge in double for where it differs."""

from typing import Any

import numpy as np
import numpy.typing as npt

import viscache as vc

Array = npt.NDArray[Any]


def soup(n: int, seed: int = 0, edge: float | None = None) -> tuple[Array, Array]:
    """Triangles without order in [−1, 1]³, their edges about 2·n^(−1/3)."""
    r = np.random.default_rng(seed)
    size = (edge or 2 * n ** (-1 / 3)) / 3
    vertices = r.uniform(-1, 1, (n, 1, 3)) + r.normal(0, size, (n, 3, 3))
    return vertices.reshape(-1, 3).astype(np.float32), np.arange(3 * n).reshape(-1, 3)


def flat(scene: vc.Scene) -> Array:
    """Corners (T, 3, 3) of a scene without instances, in double."""
    return np.concatenate([m["vertices"][m["triangles"]] for m in scene.meshes()]).astype(float)


def unit(v: Array) -> Array:
    return v / np.linalg.norm(v, axis=-1, keepdims=True)


def rays_of_every_kind(
    corners: Array, n: int, n_directions: int, seed: int = 1
) -> dict[str, Array]:
    """Rays (N, 2, 3): origin and direction, around and inside of a scene."""
    r = np.random.default_rng(seed)
    lo, hi = corners.min((0, 1)), corners.max((0, 1))
    center, radius = (lo + hi) / 2, np.linalg.norm(hi - lo) / 2
    a, b = unit(r.normal(size=(2, n, 3)))
    inside = r.uniform(lo, hi, (n, 3))
    axes = vc.vlf.directions(n_directions)[r.integers(0, n_directions, n)] * r.choice(
        [-1, 1], (n, 1)
    )
    of = r.integers(0, len(corners), n)
    spots = np.einsum("nk,nkc->nc", r.dirichlet((1, 1, 1), n), corners[of])
    along = corners[of, 1] - corners[of, 0]
    grazing = unit(along) + 1e-3 * r.normal(size=(n, 3))
    principal = np.eye(3)[r.integers(0, 3, n)] * r.choice([-1, 1], (n, 1))
    kinds = {
        "chords": (center + radius * a, radius * (b - a)),
        "interior": (inside, r.normal(size=(n, 3))),
        "grazing": (spots - 0.3 * radius * grazing, grazing),
        "aligned": (inside, axes),
        "axis-parallel": (inside, principal),
    }
    return {k: np.stack(v, 1).astype(np.float32) for k, v in kinds.items()}


def distance_to_edges(corners: Array, o: Array, d: Array) -> Array:
    """Least distance of lines o + t·d to the edges of triangles (K, 3, 3), in double."""
    least = np.full(len(o), np.inf)
    u = unit(d)
    for k in range(3):
        p, q = corners[:, k], corners[:, (k + 1) % 3]
        e, w = q - p, p - o
        # Across the line, the segment is one in the plane: its nearest place to 0
        across_e, across_w = (v - (v * u).sum(1, keepdims=True) * u for v in (e, w))
        with np.errstate(invalid="ignore", divide="ignore"):
            s = -(across_e * across_w).sum(1) / (across_e * across_e).sum(1)
        s = np.clip(np.nan_to_num(s), 0, 1)[:, None]
        least = np.minimum(least, np.linalg.norm(across_w + s * across_e, axis=1))
    return least


def times_in_double(corners: Array, o: Array, d: Array) -> Array:
    """t of rays and triangles (K, 3, 3) in double, inf for a miss [Möller, Trumbore 1997]."""
    e1, e2, s = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0], o - corners[:, 0]
    h, q = np.cross(d, e2), np.cross(s, e1)
    det = (e1 * h).sum(1)
    with np.errstate(invalid="ignore", divide="ignore"):
        u, v, t = (s * h).sum(1) / det, (d * q).sum(1) / det, (e2 * q).sum(1) / det
        inside = (u >= 0) & (v >= 0) & (u + v <= 1) & (t > 0)
    return np.where(inside, t, np.inf)


def inexcusable(
    corners: Array,
    rays: Array,
    ours: Array,
    theirs: Array,
    t: Array,
    u: Array,
    rounding: float = 1e-6,
) -> Array:
    """Rays whose two answers (triangles, −1 for none, at t and u) no rounding explains.

    Excused: the line passes an edge of either triangle by less than `rounding` radii, both hits
    lie within 1e-5 radii of each other, or the answer is ours that both triangles give in double.
    """
    radius = np.linalg.norm(np.ptp(corners, axis=(0, 1))) / 2
    o, d = rays[:, 0].astype(float), rays[:, 1].astype(float)
    edges, exact = np.full(len(o), np.inf), np.full((2, len(o)), np.inf)
    for k, answer in enumerate((ours, theirs)):
        some = answer >= 0
        parts = corners[answer[some]], o[some], d[some]
        edges[some] = np.minimum(edges[some], distance_to_edges(*parts))
        exact[k, some] = times_in_double(*parts)
    with np.errstate(invalid="ignore"):
        apart = np.abs(t.astype(float) - u) * np.linalg.norm(d, axis=1)
    near = (ours >= 0) & (theirs >= 0) & (apart < 1e-5 * radius)
    right = np.where(ours >= 0, exact[0] < exact[1], np.isinf(exact[1]))
    return (ours != theirs) & ~near & ~right & ~(edges < rounding * radius)

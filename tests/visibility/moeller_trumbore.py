"""Every ray against every triangle in double precision: the slow truth about hits."""

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[Any]


class Hits(NamedTuple):
    """Nearest hits, and how clear they are."""

    t: Array  #: inf where nothing is hit
    triangle: Array  #: -1 where nothing is hit
    uv: Array
    margin: Array  #: smallest relative distance of any triangle's decision to its other outcome


def cross_all(vertices: Array, triangles: Array, origins: Array, directions: Array) -> Hits:
    """Möller and Trumbore 1997; (T, 3) triangles, (N, 3) rays, chunked over rays."""
    a, b, c = (vertices.astype(float)[triangles[:, i]] for i in range(3))
    e1, e2 = b - a, c - a
    found = [
        _chunk(a, e1, e2, o, d) for o, d in zip(_split(origins), _split(directions), strict=True)
    ]
    return Hits(*(np.concatenate(parts) for parts in zip(*found, strict=True)))


def _split(rays: Array) -> list[Array]:
    return np.array_split(rays.astype(float), max(1, len(rays) // 256))


def _chunk(a: Array, e1: Array, e2: Array, o: Array, d: Array) -> tuple[Array, ...]:
    with np.errstate(divide="ignore", invalid="ignore"):
        p = np.cross(d[:, None], e2)
        det = np.einsum("ntk,tk->nt", p, e1)
        s = o[:, None] - a
        u = np.einsum("ntk,ntk->nt", s, p) / det
        q = np.cross(s, e1)
        v = np.einsum("nk,ntk->nt", d, q) / det
        t = np.einsum("ntk,tk->nt", q, e2) / det
        # All must be >= 0; the least of them decides and tells how close the call is
        least = np.minimum(np.minimum(u, v), 1 - u - v)
        inside = (least >= 0) & (t >= 0) & (det != 0)
        scale = np.linalg.norm(e1, axis=1) + np.linalg.norm(e2, axis=1)
        near = np.abs(t) * np.linalg.norm(d, axis=1)[:, None] / scale
        undecided = np.where(least > -1e-3, np.minimum(np.abs(least), near), 1.0)
        undecided = np.where(np.isfinite(undecided), undecided, 0.0)
    t = np.where(inside, t, np.inf)
    nearest = np.argmin(t, axis=1)
    rows = np.arange(len(o))
    hit = np.isfinite(t[rows, nearest])
    uv = np.stack([u[rows, nearest], v[rows, nearest]], -1)
    return (
        t[rows, nearest],
        np.where(hit, nearest, -1),
        np.where(hit[:, None], uv, np.nan),
        undecided.min(axis=1),
    )

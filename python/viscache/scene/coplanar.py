"""Measures how much of a mesh consists of subdivided flat faces."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

TOLERANCE_RAD = 1e-4


def coplanar_share(vertices: npt.ArrayLike, triangles: npt.ArrayLike) -> float:
    """Fraction of triangles that are coplanar with a triangle across one of their edges.

    Parameters
    ----------
    vertices : (V, 3) array
        Positions. Edges are matched by position, so vertices may be duplicated.
    triangles : (T, 3) array of int
        Vertex indices.

    Returns
    -------
    float
        In [0, 1]; 0 for no triangles. Two triangles count when they share an edge and their
        planes are parallel within 1e-4 rad (with a shared edge that makes them coplanar).
        Degenerate triangles never count.
    """
    points = np.ascontiguousarray(vertices, np.float32).reshape(-1, 3) + np.float32(0)  # -0 is 0
    faces = np.asarray(triangles, np.int64).reshape(-1, 3)
    if len(faces) == 0:
        return 0.0
    # One number per position: a hash of the bits of the three floats.
    bits = np.ascontiguousarray(points).view(np.uint32).astype(np.uint64)
    with np.errstate(over="ignore"):
        key = _mix(bits[:, 0] + _mix(bits[:, 1] + _mix(bits[:, 2] + np.uint64(0x9E3779B97F4A7C15))))
        ends = key[faces]
        a, b = ends, np.roll(ends, -1, axis=1)
        edge = _mix(np.minimum(a, b) + _mix(np.maximum(a, b))).ravel()
    owner = np.repeat(np.arange(len(faces)), 3)
    order = np.argsort(edge, kind="stable")
    edge, owner = edge[order], owner[order]
    # Unit normals in double, from the positions as stored.
    p, q, r = (points[faces[:, k]].astype(float) for k in range(3))
    normal = np.cross(q - p, r - p)
    length = np.linalg.norm(normal, axis=1)
    normal /= np.maximum(length, 1e-300)[:, None]
    flat = np.zeros(len(faces), bool)
    for step in (1, 2, 3):  # edges with up to four owners
        same = np.flatnonzero(edge[step:] == edge[:-step])
        first, second = owner[same], owner[same + step]
        sine = np.linalg.norm(np.cross(normal[first], normal[second]), axis=1)
        hit = (sine < TOLERANCE_RAD) & (length[first] > 0) & (length[second] > 0)
        flat[first[hit]] = flat[second[hit]] = True
    return float(flat.mean())


def _mix(x: npt.NDArray[np.uint64]) -> npt.NDArray[np.uint64]:
    # splitmix64's finaliser
    x = (x ^ (x >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    x = (x ^ (x >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    mixed: npt.NDArray[np.uint64] = x ^ (x >> np.uint64(31))
    return mixed

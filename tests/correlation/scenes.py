"""Small scenes whose visibility is known."""

from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.spatial import ConvexHull

import viscache as vc
from viscache.scenes.shapes import Indices

Array = npt.NDArray[Any]


def convex(radius: float = 1.0, at=(0.0, 0.0, 0.0), vertices: int = 500) -> vc.Scene:
    """A body that hides the upper hemisphere of none of its points, facing outwards."""
    v = np.random.default_rng(6).normal(size=(vertices, 3))
    v *= radius / np.linalg.norm(v, axis=1, keepdims=True)
    hull = ConvexHull(v)
    inwards = np.linalg.det(v[hull.simplices]) < 0
    faces = np.where(inwards[:, None], hull.simplices[:, ::-1], hull.simplices)
    return vc.Scene.from_arrays(v + np.asarray(at), faces)


def squares(cells: int = 1) -> tuple[Array, Indices]:
    """The unit square in z = 0, cut up, facing +z."""
    t = np.linspace(0, 1, cells + 1)
    x, y = np.meshgrid(t, t)
    a = (np.arange(cells)[:, None] * (cells + 1) + np.arange(cells)).ravel()
    quads = np.stack([a, a + 1, a + cells + 2, a, a + cells + 2, a + cells + 1], 1)
    vertices = np.stack([x.ravel(), y.ravel(), 0 * x.ravel()], 1)
    return vertices, quads.reshape(-1, 3).astype(np.uint32)


def masked(share: float) -> vc.Scene:
    """The unit square facing +z, solid for x < share, a hole beyond; another one metre below."""
    d = vc.SceneDescription()
    texels = np.ones((4, 1000, 4), np.float32)
    texels[:, round(1000 * share) :, 3] = 0
    holed = d.add_material(alpha_texture=d.add_image(texels), alpha_cutoff=0.5)
    vertices, triangles = squares()
    d.add_mesh(vertices, triangles, material=holed, uvs=vertices[:, :2])
    d.add_mesh(vertices - [0, 0, 1], triangles, material=d.add_material())
    d.add_camera((0.5, 0.5, 3), (0.5, 0.5, 0), up=(0, 1, 0), fov_deg=30)
    return vc.Scene.from_description(d)


def clutter(seed: int = 0, n: int = 300) -> vc.Scene:
    """Triangles without order, under an open sky."""
    r = np.random.default_rng(seed)
    vertices = (r.uniform(-1, 1, (n, 1, 3)) + r.normal(0, 0.3, (n, 3, 3))).reshape(-1, 3)
    return vc.Scene.from_arrays(vertices, np.arange(3 * n).reshape(-1, 3))


def unpacked(bits: Array, n_directions: int) -> Array:
    """Rows of bits as booleans; the order of bits does not come from NumPy."""
    k = np.arange(n_directions)
    return (bits[:, k // 64] >> (k % 64).astype(np.uint64) & np.uint64(1)).astype(bool)


def above(normals: Array, directions: Array) -> Array:
    """n·ω > 0 as the core computes it, in float32, term by term."""
    (x, y, z), (nx, ny, nz) = directions.T[:, None], normals.T[:, :, None]
    return np.asarray(x * nx + y * ny + z * nz > 0)

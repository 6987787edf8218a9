"""The ray sets of `viscache bench rays`, as arrays for any ray caster."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

import viscache as vc

Array: TypeAlias = npt.NDArray[np.float32]

#: camera: an image's rays, row by row. hemi: one cosine-distributed direction from each of N points
#: spread evenly over the surfaces. ao: the same, no longer than 5 % of the scene's diagonal.
#: p2p: from one random surface point to another.
SETS = ("camera", "hemi", "ao", "p2p")
AO_REACH = 0.05


@dataclass(frozen=True, kw_only=True, slots=True)
class RaySet:
    """Rays from `origins` along `directions`, up to `t_max` in units of the direction's length."""

    name: str
    origins: Array
    directions: Array
    t_max: float

    def __len__(self) -> int:
        return len(self.origins)


def make_ray_set(scene: vc.Scene, name: str, n: int, *, seed: int = 7) -> RaySet:
    """N rays of one of `SETS`; the same arrays for the same arguments."""
    rng = np.random.Generator(np.random.PCG64(seed))
    if name == "camera":
        return _camera_rays(scene, n)
    points, normals = surface_points(scene, n, rng)
    reach = float(np.linalg.norm(np.diff(scene.bounds, axis=0)))
    # Far enough off the surface that all casters agree on hits
    origins = (points + normals * (1e-4 * reach)).astype(np.float32)
    if name in ("hemi", "ao"):
        directions = _cosine_directions(normals, rng)
        t_max = float("inf") if name == "hemi" else AO_REACH * reach
        return RaySet(name=name, origins=origins, directions=directions, t_max=t_max)
    if name == "p2p":
        ends = origins[rng.permutation(n)]
        return RaySet(name=name, origins=origins, directions=ends - origins, t_max=0.9999)
    raise ValueError(f"ray set must be one of {', '.join(SETS)}, got {name!r}")


def surface_points(scene: vc.Scene, n: int, rng: np.random.Generator) -> tuple[Array, Array]:
    """N points distributed by area over the scene's own meshes, with normals on random sides."""
    corners = _corners(scene)
    a, ab, ac = corners[:, 0], corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    normals = np.cross(ab, ac)
    areas = np.linalg.norm(normals, axis=1)
    edges = np.cumsum(areas)
    pick = np.searchsorted(edges, rng.random(n) * edges[-1], side="right").clip(0, len(areas) - 1)
    u = np.sqrt(rng.random((n, 1)))
    v = rng.random((n, 1)) * u
    points = a[pick] + (u - v) * ab[pick] + v * ac[pick]
    side = np.where(rng.random(n) < 0.5, 1.0, -1.0)[:, None]
    unit = normals[pick] * side / areas[pick, None]
    return points.astype(np.float32), unit.astype(np.float32)


def _cosine_directions(normals: Array, rng: np.random.Generator) -> Array:
    # A point on the unit sphere around the tip of the normal is cosine-distributed
    z = 2 * rng.random(len(normals)) - 1
    phi = 2 * np.pi * rng.random(len(normals))
    r = np.sqrt(np.maximum(0, 1 - z * z))
    sphere = np.stack([r * np.cos(phi), r * np.sin(phi), z], axis=1)
    d = normals + 0.999 * sphere
    unit: Array = (d / np.linalg.norm(d, axis=1, keepdims=True)).astype(np.float32)
    return unit


def _camera_rays(scene: vc.Scene, n: int) -> RaySet:
    side = max(1, round(n**0.5))
    camera = scene.cameras[0] if scene.cameras else scene.overview_camera()
    across = np.tan(camera.fov_rad / 2) * ((np.arange(side) + 0.5) / side * 2 - 1)
    x, y = np.meshgrid(across, -across)
    forward, right, up = (np.asarray(v) for v in (camera.forward, camera.right, camera.up))
    d = forward + x[..., None] * right + y[..., None] * up
    d = (d / np.linalg.norm(d, axis=-1, keepdims=True)).reshape(-1, 3).astype(np.float32)
    o = np.broadcast_to(np.asarray(camera.origin, np.float32), d.shape).copy()
    return RaySet(name="camera", origins=o, directions=d, t_max=float("inf"))


def g_buffer(scene: vc.Scene, side: int) -> tuple[Array, Array]:
    """First hits of a square image, moved off the surface towards the camera, and normals."""
    rays = make_ray_set(scene, "camera", side * side)
    hits = scene.intersect(rays.origins, rays.directions)
    hit = hits.triangle >= 0
    tri = _corners(scene)[hits.triangle[hit]]
    n = np.cross(tri[:, 1] - tri[:, 0], tri[:, 2] - tri[:, 0])
    n /= np.linalg.norm(n, axis=1, keepdims=True)
    d = rays.directions[hit]
    n *= -np.sign(np.sum(n * d, axis=1, keepdims=True))
    points = rays.origins[hit] + hits.t[hit, None] * d + n * 1e-4
    return points.astype(np.float32), n.astype(np.float32)


def _corners(scene: vc.Scene) -> npt.NDArray[np.float64]:
    """(N, 3, 3) corners of the triangles of the scene's own meshes."""
    meshes = [m for m in scene.meshes() if m["in_world"]]
    corners = [np.asarray(m["vertices"])[np.asarray(m["triangles"])] for m in meshes]
    return np.concatenate(corners).astype(np.float64)

"""Shapes that tessellate at any detail: soft boxes, swept tubes, turned profiles, cloth.

A shape can compute its number of triangles at a given detail without building them, so that a scene
can be fitted to a triangle budget. Curved surfaces are sheared grids: rows are shifted against each
other, so that even a cylinder has no two coplanar neighbouring triangles. All shapes are in metres,
y up, with their base at y = 0 or centred at the origin as documented.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
Indices = npt.NDArray[np.uint32]
Position = Callable[[Array, Array], Array]
Warp = Callable[[Array], Array]

SHEAR = 0.37  # fraction of a column per row; 0.5 would give diamonds of coplanar triangles


def place(
    at: npt.ArrayLike = (0.0, 0.0, 0.0),
    yaw: npt.ArrayLike = 0.0,
    scale: npt.ArrayLike = 1.0,
    pitch: npt.ArrayLike = 0.0,
    roll: npt.ArrayLike = 0.0,
) -> Array:
    """Transforms (..., 4, 4): scale, then roll (z), pitch (x), yaw (y) in degrees, then move.

    All arguments broadcast; `at` and a vector `scale` have a last axis of 3.
    """
    at = np.asarray(at, float)
    scales = np.asarray(scale, float)
    if scales.ndim == 0 or scales.shape[-1] != 3:
        scales = np.repeat(scales[..., None], 3, axis=-1)
    a, b, c = (np.radians(np.asarray(x, float)) for x in (yaw, pitch, roll))
    shape = np.broadcast_shapes(at.shape[:-1], a.shape, b.shape, c.shape, scales.shape[:-1])
    a, b, c = (np.broadcast_to(x, shape) for x in (a, b, c))
    turn = _rotation(1, a) @ _rotation(0, b) @ _rotation(2, c)
    out = np.zeros((*shape, 4, 4))
    out[..., :3, :3] = turn * scales[..., None, :]
    out[..., :3, 3] = at
    out[..., 3, 3] = 1
    return out


def _rotation(axis: int, angle: Array) -> Array:
    out = np.zeros((*angle.shape, 3, 3))
    i, j = (axis + 1) % 3, (axis + 2) % 3
    out[..., axis, axis] = 1
    out[..., i, i] = out[..., j, j] = np.cos(angle)
    out[..., i, j], out[..., j, i] = -np.sin(angle), np.sin(angle)
    return out


def knots(text: str) -> Array:
    """Points (K, D) of a text such as "0.02 0.13, 0.5 0.14"."""
    return np.array([[float(x) for x in point.split()] for point in text.split(",")])


def smooth_path(points: npt.ArrayLike, samples: int = 33) -> Array:
    """Catmull-Rom curve through `points` (K, D), resampled at `samples` equal arc lengths."""
    p = np.asarray(points, float)
    ends = np.concatenate([2 * p[:1] - p[1:2], p, 2 * p[-1:] - p[-2:-1]])
    t = np.linspace(0, len(p) - 1, 4 * samples)
    k = np.minimum(t.astype(int), len(p) - 2)
    f = (t - k)[:, None]
    a, b, c, d = (ends[k + i] for i in range(4))
    cubic = (
        2 * b + (c - a) * f + (2 * a - 5 * b + 4 * c - d) * f**2 + (3 * b - a - 3 * c + d) * f**3
    )
    return even_path(0.5 * cubic, samples)


def even_path(points: npt.ArrayLike, samples: int) -> Array:
    """The polyline `points` (K, D) resampled at `samples` equal arc lengths."""
    p = np.asarray(points, float)
    length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(p, axis=0), axis=1))])
    at = np.linspace(0, length[-1], samples)
    return np.stack([np.interp(at, length, p[:, i]) for i in range(p.shape[1])], axis=1)


@dataclass(frozen=True)
class Shape:
    """Base: a fixed mesh, the same at every detail."""

    vertices: Array
    triangles: Indices

    def n_triangles(self, detail: float) -> int:
        """Number of triangles of `mesh(detail)`."""
        return len(self.triangles)

    def mesh(self, detail: float) -> tuple[Array, Indices]:
        """Vertices (V, 3) and triangles (T, 3) at `detail` (1 = as designed)."""
        return self.vertices, self.triangles


def _steps(base: float, detail: float, least: int) -> int:
    return max(least, int(base * detail + 0.5))


@dataclass(frozen=True)
class Surface(Shape):
    """A grid of `nu` x `nv` cells over position(u, v), u and v in [0, 1].

    `closed`: u wraps around. `caps`: (start, end) rows closed by a shallow dome of `dome` times
    their radius.
    """

    position: Position
    nu: float
    nv: float
    closed: bool = True
    caps: tuple[bool, bool] = (False, False)
    dome: float = 0.15
    least: tuple[int, int] = (3, 1)

    def _grid(self, detail: float) -> tuple[int, int]:
        return _steps(self.nu, detail, self.least[0]), _steps(self.nv, detail, self.least[1])

    def n_triangles(self, detail: float) -> int:
        nu, nv = self._grid(detail)
        return 2 * nu * nv + nu * sum(self.caps)

    def mesh(self, detail: float) -> tuple[Array, Indices]:
        nu, nv = self._grid(detail)
        columns = nu if self.closed else nu + 1
        i, j = np.meshgrid(np.arange(columns), np.arange(nv + 1))
        u = ((i + SHEAR * j) / nu) % 1.0 if self.closed else i / nu
        vertices = self.position(u, j / nv).reshape(-1, 3)
        a = (np.arange(nv)[:, None] * columns + np.arange(nu)[None]).ravel()
        right = (a // columns) * columns + (a % columns + 1) % columns
        quads = np.stack([a, right, a + columns, right, right + columns, a + columns], axis=-1)
        triangles = quads.reshape(-1, 3)
        if any(self.caps):
            vertices, triangles = self._cap(vertices, triangles, columns)
        return vertices, triangles.astype(np.uint32)

    def _cap(
        self, vertices: Array, triangles: npt.NDArray[np.int64], columns: int
    ) -> tuple[Array, npt.NDArray[np.int64]]:
        rows = vertices.reshape(-1, columns, 3)
        middles = rows.sum(axis=1) / columns
        ring = np.arange(columns)
        following = (ring + 1) % columns
        tops, fans = [], []
        for wanted, row, inner in zip(self.caps, (0, len(rows) - 1), (1, -2), strict=True):
            if not wanted:
                continue
            middle, spokes = middles[row], rows[row] - middles[row]
            # The normal of the ring from three of its points, facing away from the next row.
            x, y, z = spokes[0], spokes[columns // 3], spokes[2 * columns // 3]
            normal = _cross(x, y) + _cross(y, z) + _cross(z, x)
            outward = 1.0 if normal @ (middle - middles[inner]) >= 0 else -1.0
            height = outward * self.dome * np.sqrt(spokes[0] @ spokes[0])
            tops.append(middle + normal * (height / max(np.sqrt(normal @ normal), 1e-30)))
            apex = np.full(columns, len(vertices) + len(tops) - 1)
            edge = (following, ring) if row == 0 else (ring, following)
            fans.append(np.stack([*(row * columns + k for k in edge), apex], axis=-1))
        return np.concatenate([vertices, tops]), np.concatenate([triangles, *fans])


def _cross(a: Array, b: Array) -> Array:
    # np.cross has a large overhead for single vectors.
    return np.array(
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    )


@dataclass(frozen=True)
class SoftBox(Shape):
    """A box with rounded edges and slightly bulging faces, centred at the origin.

    Points q of the cube are mapped to q / |q|_power, so `power` 2 is an ellipsoid and 30 almost a
    box. `bulge` is relative to half of the smallest size.
    """

    size: tuple[float, float, float]
    cells: tuple[float, float, float]
    power: float
    bulge: float
    warp: Warp | None = None

    def _grid(self, detail: float) -> tuple[int, int, int]:
        x, y, z = (_steps(n, detail, 1) for n in self.cells)
        return x, y, z

    def n_triangles(self, detail: float) -> int:
        x, y, z = self._grid(detail)
        return 4 * (x * y + y * z + z * x)

    def mesh(self, detail: float) -> tuple[Array, Indices]:
        grid = self._grid(detail)
        points: list[Array] = []
        triangles: list[npt.NDArray[np.int64]] = []
        start = 0
        for axis in range(3):
            i, j = (axis + 1) % 3, (axis + 2) % 3
            s, t = (self._nodes(grid[k]) for k in (i, j))
            cell = np.arange(grid[i])[:, None] * len(t) + np.arange(grid[j])[None]
            a = cell.ravel()
            for side in (-1.0, 1.0):
                face = np.empty((len(s), len(t), 3))
                face[..., i], face[..., j], face[..., axis] = s[:, None], t[None], side
                points.append(face.reshape(-1, 3))
                b, c, d = a + len(t), a + len(t) + 1, a + 1
                quads = [a, b, c, a, c, d] if side > 0 else [a, c, b, a, d, c]
                triangles.append(np.stack(quads, axis=-1).reshape(-1, 3) + start)
                start += len(s) * len(t)
        return self._round(np.concatenate(points)), np.concatenate(triangles).astype(np.uint32)

    def _nodes(self, n: int) -> Array:
        # Not symmetric, so that no cell's corners are mirror images (which would be coplanar).
        t = np.linspace(-1, 1, n + 1)
        return t + 0.07 * (1 - t * t)

    def _round(self, q: Array) -> Array:
        flat = 1 - q * q
        bulge = self.bulge * min(self.size) / np.asarray(self.size)
        raised = q * (1 + bulge * flat[:, [1, 2, 0]] * flat[:, [2, 0, 1]])
        norm = (np.abs(q) ** self.power).sum(axis=1) ** (1 / self.power)
        p: Array = raised / norm[:, None] * (np.asarray(self.size) / 2)
        return p if self.warp is None else self.warp(p)


_NO_VERTICES = np.zeros((0, 3))
_NO_TRIANGLES = np.zeros((0, 3), np.uint32)


def box(low: npt.ArrayLike, high: npt.ArrayLike) -> Shape:
    """A plain box of 12 triangles from corner `low` to corner `high`, facing outwards."""
    lo, hi = np.asarray(low, float), np.asarray(high, float)
    corner = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], float)
    faces = ["0132", "4675", "0451", "2376", "0264", "1573"]
    triangles = [[int(f[k]) for k in t] for f in faces for t in ((0, 1, 2), (0, 2, 3))]
    return Shape(lo + corner * (hi - lo), np.array(triangles, np.uint32))


def quad(*corners: npt.ArrayLike) -> Shape:
    """Two triangles a, b, c and a, c, d; the normal is (b - a) x (c - a)."""
    return Shape(np.asarray(corners, float), np.array([[0, 1, 2], [0, 2, 3]], np.uint32))


def soft_box(
    size: tuple[float, float, float],
    cells: tuple[float, float, float] = (3, 3, 3),
    *,
    power: float = 16.0,
    bulge: float = 0.02,
    warp: Warp | None = None,
) -> SoftBox:
    """Rounded box of outer `size`, centred; `cells` per axis at detail 1."""
    return SoftBox(_NO_VERTICES, _NO_TRIANGLES, size, cells, power, bulge, warp)


def sphere(radius: float, cells: float = 6, warp: Warp | None = None) -> SoftBox:
    """Sphere (six `cells` x `cells` faces), centred."""
    return soft_box((2 * radius,) * 3, (cells,) * 3, power=2, bulge=0, warp=warp)


def bumpy_sphere(
    radius: float, cells: float = 10, phase: float = 0.0, depth: float = 0.08
) -> SoftBox:
    """Sphere with radius r (1 + depth sin 9t sin 11p + depth/2 sin(31t + 5p) sin t), centred."""

    def bumps(q: Array) -> Array:
        x, y, z = q.T / radius
        t, p = np.arccos(np.clip(y, -1, 1)), np.arctan2(z, x) + phase
        wave = np.sin(9 * t) * np.sin(11 * p) + 0.5 * np.sin(31 * t + 5 * p) * np.sin(t)
        bumpy: Array = q * (1 + depth * wave)[:, None]
        return bumpy

    return sphere(radius, cells, bumps)


def surface(
    position: Position,
    nu: float,
    nv: float,
    *,
    closed: bool = False,
    caps: tuple[bool, bool] = (False, False),
    dome: float = 0.15,
    least: tuple[int, int] | None = None,
) -> Surface:
    """Any parametric surface; see `Surface`."""
    least = least or ((3, 1) if closed else (1, 1))
    return Surface(_NO_VERTICES, _NO_TRIANGLES, position, nu, nv, closed, caps, dome, least)


def revolve(
    profile: npt.ArrayLike,
    nu: float = 16,
    nv: float = 12,
    *,
    caps: tuple[bool, bool] = (True, False),
    flutes: tuple[int, float] = (0, 0.0),
    smooth: bool = True,
    dome: float = 0.1,
) -> Surface:
    """Turned body around y: `profile` is (radius, height) from bottom to top.

    `flutes` = (number, relative depth) waves the radius around the axis.
    """
    curve = smooth_path(profile) if smooth else even_path(profile, 129)
    knots = np.linspace(0, 1, len(curve))
    number, depth = flutes

    def position(u: Array, v: Array) -> Array:
        radius = np.interp(v, knots, curve[:, 0]) * (1 + depth * np.cos(2 * np.pi * number * u))
        y = np.interp(v, knots, curve[:, 1])
        angle = 2 * np.pi * u
        return np.stack([radius * np.sin(angle), y, radius * np.cos(angle)], axis=-1)

    return surface(position, nu, nv, closed=True, caps=caps, dome=dome, least=(3, 2))


def cylinder(radius: float, height: float, nu: float = 14, nv: float = 2) -> Surface:
    """Upright cylinder from y = 0 to `height` with slightly domed ends."""
    return revolve([[radius, 0], [radius, height]], nu, nv, caps=(True, True), smooth=False)


def tube(
    points: npt.ArrayLike,
    radius: float | npt.ArrayLike,
    nu: float = 7,
    nv: float = 10,
    *,
    smooth: bool = True,
    caps: tuple[bool, bool] = (True, True),
) -> Surface:
    """Round bar along a path (K, 3); `radius` is one number or evenly spaced values along it."""
    path = smooth_path(points) if smooth else even_path(points, 33)
    knots = np.linspace(0, 1, len(path))
    radii = np.atleast_1d(np.asarray(radius, float))
    radius_knots = np.linspace(0, 1, len(radii))
    tangent = np.gradient(path, axis=0)
    tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
    # The normal of the best-fitting plane is never along the path.
    reference = np.linalg.svd(path - path.mean(axis=0), full_matrices=True)[2][2]
    side = np.cross(tangent, reference)
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    other = np.cross(side, tangent)
    columns = np.concatenate([path, side, other], axis=1)

    def position(u: Array, v: Array) -> Array:
        c = np.stack([np.interp(v[:, 0], knots, columns[:, k]) for k in range(9)], axis=1)[:, None]
        r = np.interp(v, radius_knots, radii)[..., None]
        angle = 2 * np.pi * u[..., None]
        return np.asarray(
            c[..., :3] + r * (np.cos(angle) * c[..., 3:6] + np.sin(angle) * c[..., 6:])
        )

    return surface(position, nu, nv, closed=True, caps=caps)


def rod(start: npt.ArrayLike, end: npt.ArrayLike, radius: float, nu: float = 6) -> Surface:
    """Straight round bar with a slight belly."""
    a, b = np.asarray(start, float), np.asarray(end, float)
    return tube(np.linspace(a, b, 3), [radius * 0.85, radius, radius * 0.85], nu, 4, smooth=False)


def curtain(width: float, height: float, folds: int = 9, depth: float = 0.06) -> Surface:
    """Hanging cloth in the plane z = 0, x centred, from y = 0 up; folds open towards the hem."""

    def position(u: Array, v: Array) -> Array:
        loose = 1.15 - 0.65 * v
        phase = 2 * np.pi * folds * u + 0.9 * np.sin(5 * v + 3 * u)
        x = (u - 0.5) * width + 0.012 * np.sin(11 * v + 17 * u)
        z = depth * loose * (np.sin(phase) + 0.25 * np.sin(2.3 * phase + 4 * v))
        return np.stack([x, v * height, z], axis=-1)

    return surface(position, 7 * folds, 14, least=(2 * folds, 2))


def cloth(size: tuple[float, float], bumps: float = 0.004, waves: float = 60.0) -> Surface:
    """Woven or piled cloth lying in x-z, centred, with a bumpy upper side just above y = 0."""

    def position(u: Array, v: Array) -> Array:
        x, z = (u - 0.5) * size[0], (v - 0.5) * size[1]
        weave = np.sin(waves * x + 0.7 * np.sin(9 * z)) * np.sin(waves * z + 0.6 * np.sin(7 * x))
        swell = 0.8 * np.sin(2.1 * x + 1.3 * z)
        edge = np.minimum(1, 12 * np.minimum(np.minimum(u, 1 - u), np.minimum(v, 1 - v)))
        y = (bumps * (2.2 + weave + swell)) * (0.3 + 0.7 * edge)
        return np.stack([x, y, z], axis=-1)

    return surface(position, 24 * size[0], 24 * size[1], least=(2, 2))


def leaf(length: float, width: float, droop: float = 0.35, nu: float = 2, nv: float = 4) -> Surface:
    """A folded, drooping leaf from the origin along +z."""

    def position(u: Array, v: Array) -> Array:
        across = (2 * u - 1) * width / 2 * np.sin(np.pi * np.clip(v, 0.03, 0.985)) ** 0.8
        y = 0.55 * np.abs(across) * (1 - 0.8 * v) + droop * length * (0.6 * v - 1.1 * v * v)
        z = length * (v - 0.12 * droop * v * v) + 0.0 * across
        return np.stack([across + 0.04 * length * np.sin(3 * v), y, z], axis=-1)

    return surface(position, nu, nv, least=(2, 2))

"""Analytic scenes on the sphere's map: true visibility per texel, records, and exact variances.

`room`: 8 × 8 × 4 with one window of 1 × 1 under a constant sky. `garden`: a plane under many tiny
spheres, three lamps and a sky. `courtyard`: a plane under few large spheres. A world is piecewise
constant, so every expectation is a sum over texels.
"""

from dataclasses import dataclass, field
from functools import cache

import numpy as np
import numpy.typing as npt

from viscache._core.vismap import EnvironmentPyramid, PointEstimate
from vismap.worlds import blended, dilations, directions, luminance

Doubles = npt.NDArray[np.float64]
Bools = npt.NDArray[np.bool_]
EDGE = 128
N_BEST = 4


@dataclass
class Scene:
    """Axis-parallel rectangles (axis, place, (lo, hi), (lo, hi)) and spheres (x, y, z, radius)."""

    rectangles: list[tuple[int, float, tuple[float, float], tuple[float, float]]]
    spheres: Doubles
    light: npt.NDArray[np.float32]
    exponent: float  #: of the glossy lobe; 0 = diffuse
    points: Doubles = field(default_factory=lambda: np.zeros((0, 3)))
    normals: Doubles = field(default_factory=lambda: np.zeros((0, 3)))

    def visible(self, x: Doubles, n: Doubles, d: Doubles) -> Bools:
        """Which directions (K, 3) are free from a point on a surface."""
        free = d @ n > 0
        for axis, place, *ranges in self.rectangles:
            with np.errstate(divide="ignore", invalid="ignore"):
                t = (place - x[axis]) / d[:, axis]
            hit = t > 1e-7
            for other, (lo, hi) in zip((a for a in range(3) if a != axis), ranges, strict=True):
                at = x[other] + np.where(hit, t, 0) * d[:, other]
                hit &= (at >= lo) & (at <= hi)
            free &= ~hit
        if len(self.spheres):
            o = self.spheres[:, :3] - x
            along = d @ o.T
            gap = (o**2).sum(1) - along**2 - self.spheres[:, 3] ** 2
            free &= ~((gap < 0) & (along > 0)).any(1)
        return np.asarray(free)

    def reflection(self, x: Doubles, n: Doubles) -> npt.NDArray[np.float32]:
        """B per texel, (EDGE, EDGE, 3)."""
        d = directions(EDGE).astype(np.float64)
        cosine = np.maximum(d @ n, 0)
        b = cosine / np.pi
        if self.exponent:
            wo = np.array([0.6, 0, 0.8])
            mirrored = 2 * (n @ wo) * n - wo
            lobe = np.maximum(d @ mirrored, 0) ** self.exponent
            b = 0.5 * b + 0.5 * cosine * (self.exponent + 1) / (2 * np.pi) * lobe
        return np.repeat(b[..., None], 3, axis=-1).astype(np.float32)


def _lamps(lamps: list[tuple[tuple[float, float, float], float, float]]) -> Doubles:
    d = directions(EDGE).astype(np.float64)
    light = np.where(d[..., 2] > 0, 0.5 + 0.5 * d[..., 2], 0.15)
    for towards, radius_deg, radiance in lamps:
        axis = np.asarray(towards) / np.linalg.norm(towards)
        light = light + radiance * (d @ axis > np.cos(np.radians(radius_deg)))
    return np.asarray(light)


def _grey(light: Doubles) -> npt.NDArray[np.float32]:
    return np.repeat(light[..., None], 3, axis=-1).astype(np.float32)


THREE_LAMPS = [
    ((0.5, 0.3, 0.81), 5.0, 2000.0),
    ((-0.6, 0.4, 0.69), 5.0, 2000.0),
    ((0.1, -0.8, 0.59), 5.0, 2000.0),
]


def scene(name: str, seed: int = 7) -> Scene:
    rng = np.random.default_rng(seed)
    if name == "room":
        far = (0.0, 8.0)
        walls = [
            (2, 0.0, far, far),
            (2, 4.0, far, far),
            (0, 0.0, far, (0.0, 4.0)),
            (1, 0.0, far, (0.0, 4.0)),
            (1, 8.0, far, (0.0, 4.0)),
            (0, 8.0, (0.0, 3.5), (0.0, 4.0)),
            (0, 8.0, (4.5, 8.0), (0.0, 4.0)),
            (0, 8.0, (3.5, 4.5), (0.0, 1.5)),
            (0, 8.0, (3.5, 4.5), (2.5, 4.0)),
        ]
        return Scene(walls, np.zeros((0, 4)), np.ones((EDGE, EDGE, 3), np.float32), 0)
    n, low, high = {"garden": (600, 0.08, 0.23), "courtyard": (40, 0.3, 0.8)}[name]
    r = rng.uniform(low, high, n)
    z = r + 0.05 + rng.uniform(0, 1.5, n)
    spheres = np.column_stack([rng.uniform(-1, 11, n), rng.uniform(-1, 11, n), z, r])
    return Scene([], spheres, _grey(_lamps(THREE_LAMPS)), 30)


def surface_points(name: str, n: int, rng: np.random.Generator) -> tuple[Doubles, Doubles]:
    """Points with normals: of the room but not of the window's wall, or of the plane."""
    if name != "room":
        x = np.column_stack([rng.uniform(0, 10, (n, 2)), np.full(n, 1e-6)])
        return x, np.tile([0.0, 0.0, 1.0], (n, 1))
    walls = [(2, 0.0), (2, 4.0), (0, 0.0), (1, 0.0), (1, 8.0)]
    x, normals = rng.uniform(0, 1, (n, 3)) * [8, 8, 4], np.zeros((n, 3))
    for i, wall in enumerate(rng.choice(5, n, p=np.array([64, 64, 32, 32, 32]) / 224)):
        axis, place = walls[wall]
        sign = 1.0 if place == 0 else -1.0
        x[i, axis], normals[i, axis] = place + sign * 1e-6, sign
    return x, normals


@dataclass
class Pixel:
    """A point with its truth and the records that speak for it."""

    b: npt.NDArray[np.float32]
    visible: Bools
    maps: Bools
    beta: npt.NDArray[np.float32]
    grown: list[Bools]


@dataclass
class World:
    light: npt.NDArray[np.float32]
    pyramid: EnvironmentPyramid
    pixels: list[Pixel]

    def estimate(self, pixel: Pixel, eta: float = 1.0, **replaced: object) -> PointEstimate:
        values = {"maps": pixel.maps, "dilated": pixel.grown} | replaced
        return PointEstimate(
            self.pyramid, pixel.b, values["maps"], pixel.beta, dilated=values["dilated"], eta=eta
        )


@cache
def world(name: str, *, records: int = 800, m: int = 5, pixels: int = 40, seed: int = 7) -> World:
    """A world with so many records, the four nearest of them blended at each pixel."""
    made, rng = scene(name, seed), np.random.default_rng(seed + 1)
    edge = 2**m
    places, normals = surface_points(name, records, rng)
    cells = _cell_directions(edge, records, rng)
    maps = np.stack(
        [made.visible(x, n, d) for x, n, d in zip(places, normals, cells, strict=True)]
    ).reshape(records, edge, edge)
    texels = directions(EDGE).reshape(-1, 3).astype(np.float64)
    found = []
    for x, n in zip(*surface_points(name, pixels, rng), strict=True):
        alike = normals @ n > np.cos(np.pi / 6)
        distance = np.where(alike, np.linalg.norm(places - x, axis=1), 1e9)
        near = np.argsort(distance)[:N_BEST]
        t = distance[near] / (1.25 * distance[near[-1]])
        lowest = 5 / 6 * (1 - 1 / 6)
        w = np.maximum((1 - t / (1 + 5 * t) - lowest) / (1 - lowest), 0) + 1e-9
        found.append(
            Pixel(
                b=made.reflection(x, n),
                visible=made.visible(x, n, texels).reshape(EDGE, EDGE),
                maps=maps[near],
                beta=(w / w.sum()).astype(np.float32),
                grown=dilations(maps[near]),
            )
        )
    return World(made.light, EnvironmentPyramid(made.light), found)


def _cell_directions(edge: int, n: int, rng: np.random.Generator) -> Doubles:
    """A random texel's direction in every cell, for every record, (n, edge², 3)."""
    k = EDGE * 4 // edge
    fine = directions(EDGE * 4).astype(np.float64)
    y, x = np.indices((edge, edge)) * k
    rows, columns = rng.integers(0, k, (2, n, edge, edge))
    return np.asarray(fine[y + rows, x + columns].reshape(n, -1, 3))


@dataclass
class Exact:
    """Sums over texels, in luminance: p the probabilities, f and g what V and Ṽ bring."""

    p: Doubles
    f: Doubles
    g: Doubles

    @property
    def truth(self) -> float:
        return float(self.f.sum())

    def variance(self, alpha: float) -> float:
        """Of one sample of f/p − α(g/p − J)."""
        y = np.divide(self.f - alpha * self.g, self.p, out=np.zeros_like(self.p), where=self.p > 0)
        return float((self.p * y**2).sum() - (self.p * y).sum() ** 2)

    @property
    def best_alpha(self) -> float:
        """(V(0) − V(1) + Var g)/(2 Var g) from three variances."""
        zero, one, minus = (self.variance(a) for a in (0.0, 1.0, -1.0))
        var_w = (one + minus) / 2 - zero
        return (minus - one) / 4 / var_w if var_w > 1e-14 * max(zero, 1e-300) else 0.0


def exact(made: World, pixel: Pixel, point: PointEstimate) -> Exact:
    light = luminance(made.light) * (4 * np.pi / EDGE**2)
    f = light * luminance(pixel.b) * pixel.visible
    g = light * point.b_tilde() * blended(pixel.maps, pixel.beta, EDGE)
    return Exact(point.probabilities(), f, g)

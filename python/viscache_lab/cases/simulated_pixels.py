"""Single pixels of an image, discretised by the environment's texels, with their true values."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import cache
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from viscache.base.sharing import MadeOnce
from viscache.scene import Scene
from viscache.scene.cameras import find_camera, frame_size
from viscache.vismap import Lookup, VisibilityMapCache, equations
from viscache_lab.cases.light_product import (
    LUMINANCE,
    Hits,
    environment_texels,
    first_hits,
    reflected,
)

Floats: TypeAlias = npt.NDArray[np.floating[Any]]
Doubles: TypeAlias = npt.NDArray[np.float64]
Bools: TypeAlias = npt.NDArray[np.bool_]

#: The pilot: number of points, and samples per point, with its own random numbers.
PILOT_POINTS, PILOT_SAMPLES = 1000, 16
#: Upper bound of an α from samples.
MOST_ALPHA = 1.5


@dataclass(frozen=True, kw_only=True)
class Pixel:
    """Data of one pixel, over the texels and over the cells of its maps."""

    scene: Scene
    start: Floats
    """(3,) origin of its shadow rays."""
    normal: Floats
    texels: Floats
    """(R, R, 3) radiance."""
    directions: Floats
    """(R², 3) directions to the centres of the texels."""
    b: npt.NDArray[np.float32]
    """(R, R, 3)"""
    maps: Bools
    """(n, 2^m, 2^m)"""
    beta: npt.NDArray[np.float32]
    """(n,)"""
    dilated: list[Bools]
    _made: MadeOnce = field(default_factory=MadeOnce, init=False, repr=False, compare=False)

    @property
    def visible(self) -> Bools:
        """(R, R) by one ray per texel."""
        return self._made.get("visible", self._all_texels)

    def _all_texels(self) -> Bools:
        return self.sees(np.arange(len(self.directions))).reshape(self.b.shape[:2])

    def sees(self, texels: npt.NDArray[np.integer[Any]]) -> Bools:
        """True for texels (row-major indices) whose centre is visible."""
        towards = self.directions[texels]
        above = towards @ self.normal > 0
        seen = np.zeros(len(texels), bool)
        origins = np.broadcast_to(self.start, (int(above.sum()), 3))
        seen[above] = ~self.scene.occluded(origins, towards[above])
        return seen

    def truth(self) -> float:
        """The exact luminance."""
        light = (self.texels.astype(float) * self.b)[self.visible].sum(axis=0) @ LUMINANCE
        return float(light * 4 * np.pi / self.visible.size)

    def estimate(self, light: Any, eta: float) -> Any:
        """The estimator of the core."""
        return equations.PointEstimate(
            light, self.b, self.maps, self.beta, dilated=self.dilated, eta=eta
        )

    def oracle_alpha(self, point: Any) -> float:
        """α* = Cov(f/p, g/p)/Var(g/p) of luminances under p, by summation over the texels."""
        p = point.probabilities()
        drawn = p > 0
        light = (self.texels.astype(float) @ LUMINANCE)[drawn] * (4 * np.pi / p.size)
        f = light * (self.b.astype(float) @ LUMINANCE * self.visible)[drawn]
        g = light * point.b_tilde()[drawn] * self._blended()[drawn]
        variance = float((g * g / p[drawn]).sum() - g.sum() ** 2)
        covariance = float((f * g / p[drawn]).sum() - f.sum() * g.sum())
        return covariance / variance if variance > 1e-12 * float(g.sum()) ** 2 else 0.0

    def _blended(self) -> Doubles:
        """Ṽ of the texels; zero without maps."""
        edge = len(self.b)
        if not len(self.beta):
            return np.zeros((edge, edge))
        mean = np.tensordot(self.beta.astype(float), self.maps.astype(float), axes=1)
        return np.asarray(np.kron(mean, np.ones((edge // len(mean), edge // len(mean)))), float)


class Pixels:
    """The pixels of an image that see a surface, of a scene that `light_product` accepts.

    ValueError if the scene has other lights.
    """

    def __init__(
        self, cache: VisibilityMapCache, camera: Any, size: tuple[int, int] | None
    ) -> None:
        self.cache = cache
        self._directions, self.texels = environment_texels(cache.scene)
        view = find_camera(cache.scene, camera)
        size = frame_size(size, view)
        self._hits: Hits = first_hits(cache.scene, view, size)
        self._asking = cache.asking_points(view, size)
        self.there = np.flatnonzero((self._asking[2] > 0) & (self._hits.materials >= 0))
        self.light = equations.EnvironmentPyramid(self.texels)

    def chosen(self, count: int, seed: int) -> npt.NDArray[np.int64]:
        """At most `count` randomly chosen pixels, in increasing order."""
        rng = np.random.Generator(np.random.PCG64(seed))
        return np.sort(rng.permutation(self.there)[:count])

    def at(self, chosen: npt.NDArray[np.int64]) -> Iterator[Pixel]:
        """Yields these pixels with their maps."""
        cache, hits, asking = self.cache, self._hits, self._asking
        m, edge = cache.settings.m, len(self.texels)
        lookup = cache.lookup(*(values[chosen] for values in asking))
        bits = cache.records().bits
        for row, pixel in enumerate(chosen):
            b = reflected(cache.scene, hits, pixel, self._directions).astype(np.float32)
            maps, beta, dilated = _blended(lookup, row, bits, m)
            yield Pixel(
                scene=cache.scene,
                start=hits.starts[pixel],
                normal=hits.normals[pixel],
                texels=self.texels,
                directions=self._directions,
                b=b.reshape(edge, edge, 3),
                maps=maps,
                beta=beta,
                dilated=dilated,
            )


def pooled_alphas(pixels: Pixels, ways: Sequence[tuple[float, Any]], seed: int) -> list[float]:
    """α of each way to sample from its pilot: one regression over all points, clamped to [0, 1.5].

    A way is (eta, points): the minimum of the density of its samples, and a PointSet. The seed must
    differ from that of the estimates.
    """
    covariance, variance = np.zeros(len(ways)), np.zeros(len(ways))
    chosen = pixels.chosen(PILOT_POINTS, seed) if ways else np.empty(0, np.int64)
    for number, pixel in enumerate(pixels.at(chosen)):
        for way, (eta, points) in enumerate(ways):
            point = pixel.estimate(pixels.light, eta)
            if not point.l_ns > 0:
                continue
            u = equations.points(points, PILOT_SAMPLES, seed=seed, pixel=number)
            s = point.sample(u)
            z, w, mean_w = s["z"] * pixel.sees(s["texel"]), s["w"], point.mean_w
            covariance[way] += point.l_ns**2 * float((z * w).mean() - z.mean() * mean_w)
            variance[way] += point.l_ns**2 * max(0.0, float((w * w).mean() - mean_w**2))
    return [
        min(max(c / v, 0.0), MOST_ALPHA) if v > 0 else 1.0
        for c, v in zip(covariance.tolist(), variance.tolist(), strict=True)
    ]


def _blended(
    lookup: Lookup, row: int, bits: npt.NDArray[np.uint64], m: int
) -> tuple[Bools, npt.NDArray[np.float32], list[Bools]]:
    """Maps of a looked-up point, their weights, and their dilations (V^1, V^2, V^3)."""
    speaks = lookup.beta[row] > 0
    words = [bits[i] for i in lookup.ids[row][speaks]]
    grown = 3 if m >= 6 else 2
    if not words:
        return np.zeros((0, 1 << m, 1 << m), bool), np.zeros(0, np.float32), []
    dilated = [
        np.stack([_as_image(equations.dilated(w, m, level), m - level + 1) for w in words])
        for level in range(1, grown + 1)
    ]
    return np.stack([_as_image(w, m) for w in words]), lookup.beta[row][speaks], dilated


def _as_image(words: npt.NDArray[np.uint64], m: int) -> Bools:
    """The cells of a map, row by row, from its words in Z order."""
    word, bit = _places(m)
    return np.asarray((words[word] >> bit & np.uint64(1)) > 0)


@cache
def _places(m: int) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.uint64]]:
    """Word and bit of every cell, row by row."""
    axis = np.arange(1 << m, dtype=np.uint32)
    z = equations.morton2(*np.meshgrid(axis, axis)).astype(np.int64)
    return z // 64, (z % 64).astype(np.uint64)

"""Repeated estimates of single pixels with known true visibility.

Light, reflection and visibility are constant inside each texel of the environment, so that the true
value is a sum and no reference image is needed. Reflection and visibility are those of the scene at
the centres of the texels.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from typing import Any, Literal, TypeAlias

import numpy as np
import numpy.typing as npt

from viscache.scene import Scene
from viscache.scene.cameras import Camera, find_camera, frame_size
from viscache.settings.checks import checked_threads, require
from viscache.vismap import Lookup, VisibilityMapCache, equations
from viscache.vismap.equations import AlphaMode, PointSet
from viscache_lab.cases.light_product import LUMINANCE, environment_texels, first_hits, reflected

Floats: TypeAlias = npt.NDArray[np.floating[Any]]
Doubles: TypeAlias = npt.NDArray[np.float64]
Bools: TypeAlias = npt.NDArray[np.bool_]
Alpha: TypeAlias = float | Literal["loo", "previous_pass", "oracle"]

#: The pilot: number of points, and samples per point, with its own random numbers.
PILOT_POINTS, PILOT_SAMPLES = 1000, 16
#: Upper bound of an α from samples.
MOST_ALPHA = 1.5


@dataclass(frozen=True, kw_only=True)
class Pixel:
    """Data of one pixel, over the texels and over the cells of its maps."""

    scene: Scene
    start: Floats  # (3,) origin of its shadow rays
    normal: Floats
    texels: Floats  # (R, R, 3) radiance
    directions: Floats  # (R², 3) directions to the centres of the texels
    b: npt.NDArray[np.float32]  # (R, R, 3)
    maps: Bools  # (n, 2^m, 2^m)
    beta: npt.NDArray[np.float32]  # (n,)
    dilated: list[Bools]

    @cached_property
    def visible(self) -> Bools:
        """(R, R) by one ray per texel."""
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
        self._hits = first_hits(cache.scene, view, size)
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


#: Size of the first pass of a frame with few samples, and minimum size of a pass.
FIRST_PASS = 10
#: Offset from the seeds of estimates, which count up from the given seed.
PILOT_SEED = 1 << 40
MODES: dict[Any, Any] = {
    "loo": AlphaMode.LEAVE_ONE_OUT,
    "previous_pass": AlphaMode.PREVIOUS_PASS,
}


@dataclass(frozen=True, kw_only=True, slots=True)
class Way:
    """A method to estimate a pixel, by a control variate of coefficient α.

    α is 1 in the paper, and 0 for plain product sampling; "oracle": the best for independent
    points, by summation over the true visibility.
    """

    alpha: Alpha = 0.0
    eta: float = 1.0  # the minimum of the guided density; 1: product sampling
    points: Literal["iid", "rqmc"] = "rqmc"  # independent, or a randomised (0,2)-sequence
    passes: int = 1  # the last one counts; with "previous_pass", α comes from the others
    one_shot: bool = False  # the samples are parted by `one_shot_passes`, and all of them count
    first: Literal["one", "pilot"] = "one"  # α of the first pass: 1, or that of `pooled_alphas`

    def __post_init__(self) -> None:
        require(0 < self.eta <= 1, "eta must be in (0, 1]", self.eta)
        named = self.alpha in ("loo", "previous_pass", "oracle")
        fits = named or isinstance(self.alpha, (int, float))
        require(fits, 'alpha must be a number, "loo", "previous_pass" or "oracle"', self.alpha)
        fits = self.alpha != "loo" or self.points == "iid"
        require(fits, 'alpha="loo" needs points="iid"', self.points)
        once = not self.one_shot or self.passes == 1
        require(once, "passes must be 1 with one_shot", self.passes)
        fits = self.alpha == "previous_pass" or not (self.one_shot or self.first == "pilot")
        require(fits, 'alpha must be "previous_pass" with one_shot or first="pilot"', self.alpha)

    def sizes(self, samples: int) -> list[int]:
        """Number of samples of every pass."""
        return one_shot_passes(samples) if self.one_shot else [samples] * self.passes


@dataclass(frozen=True, kw_only=True, slots=True)
class PixelEstimates:
    """Luminances of P pixels."""

    truth: npt.NDArray[np.float64]  # (P,)
    estimates: dict[tuple[Way, int], npt.NDArray[np.float64]]  # (replicates, P), by way and samples


def one_shot_passes(samples: int) -> list[int]:
    """Division of the samples of a single frame: 10, 20, 40, …, the rest; no pass below ten."""
    require(samples >= 1, "samples must be >= 1", samples)
    sizes, left, size = [], samples, FIRST_PASS
    while left >= size + FIRST_PASS:
        sizes.append(size)
        left, size = left - size, 2 * size
    return [*sizes, left]


def simulate(
    cache: VisibilityMapCache,
    ways: Sequence[Way],
    samples: Sequence[int],
    *,
    camera: str | int | Camera | None = None,
    size: tuple[int, int] | None = None,
    n_pixels: int = 256,
    replicates: int = 32,
    seed: int = 0,
    threads: int | None = None,
) -> PixelEstimates:
    """Estimate at most `n_pixels` random pixels of an image, independently and many times.

    The cache is of a scene that `light_product` accepts, and is not changed. Samples count per
    pixel and pass, or in total if the method is `one_shot`.
    """
    require(n_pixels >= 1, "n_pixels must be >= 1", n_pixels)
    require(replicates >= 2, "replicates must be >= 2", replicates)
    pixels = Pixels(cache, camera, size)
    pilots: list[tuple[float, str]] = sorted(
        {(w.eta, w.points) for w in ways if w.first == "pilot"}
    )
    alphas = pooled_alphas(pixels, [(e, _points(kind)) for e, kind in pilots], PILOT_SEED + seed)
    first = dict(zip(pilots, alphas, strict=True))
    truth: list[float] = []
    found: dict[tuple[Way, int], list[npt.NDArray[np.floating[Any]]]] = {
        (w, n): [] for w in ways for n in samples
    }
    for number, pixel in enumerate(pixels.at(pixels.chosen(n_pixels, seed))):
        truth.append(pixel.truth())
        points = {eta: pixel.estimate(pixels.light, eta) for eta in {way.eta for way in ways}}
        for way, n in found:
            point, sizes = points[way.eta], way.sizes(n)
            made = point.simulate(
                pixel.visible,
                sizes=sizes,
                replicates=replicates,
                set=_points(way.points),
                mode=MODES.get(way.alpha, AlphaMode.FIXED),
                alpha=_alpha(way, pixel, point, first),
                seed=seed + number,
                threads=checked_threads(threads),
            )
            passes = made @ LUMINANCE
            # The mean of all samples, or the last pass
            mean = passes @ np.array(sizes) / sum(sizes) if way.one_shot else passes[:, -1]
            found[way, n].append(mean)
    return PixelEstimates(
        truth=np.array(truth), estimates={k: np.stack(v, axis=1) for k, v in found.items()}
    )


def _points(kind: str) -> Any:
    return PointSet.INDEPENDENT if kind == "iid" else PointSet.ZERO_TWO


def _alpha(way: Way, pixel: Pixel, point: Any, first: Mapping[tuple[float, str], float]) -> float:
    """The given α, or that of the first pass."""
    if way.alpha == "oracle":
        return pixel.oracle_alpha(point)
    if isinstance(way.alpha, str):
        return first[way.eta, way.points] if way.first == "pilot" else 1.0
    return float(way.alpha)

"""Estimates of single pixels many times over, where the true visibility is known.

The world is that of the environment's texels: light, reflection and visibility are constant inside
each, so that the true value is a sum and no reference picture is needed. Reflection and visibility
are those of the scene at the texels' middles.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Literal, TypeAlias

import numpy as np
import numpy.typing as npt

from viscache import _core
from viscache.cameras import find_camera
from viscache.checks import checked_threads, require
from viscache.scene import Scene
from viscache.scenes.light_product import LUMINANCE, environment_texels, first_hits, reflected
from viscache.vismap.cache import Lookup, VisibilityMapCache

__all__ = ["PixelEstimates", "Way", "simulate"]

Floats: TypeAlias = npt.NDArray[np.floating[Any]]
Bools: TypeAlias = npt.NDArray[np.bool_]


@dataclass(frozen=True, kw_only=True, slots=True)
class Way:
    """One way to estimate a pixel.

    Parameters
    ----------
    alpha : float or {"loo", "previous_pass"}
        Factor of the control variate: 1 is the paper's, 0 plain product sampling.
    eta : float in (0, 1]
        Floor of the guided density; 1: product sampling.
    points : {"iid", "rqmc"}
        Independent points, or a randomised (0,2)-sequence.
    passes : int >= 1
        Passes before and with the one that counts: with "previous_pass", α comes from the others.
    """

    alpha: float | Literal["loo", "previous_pass"] = 0.0
    eta: float = 1.0
    points: Literal["iid", "rqmc"] = "rqmc"
    passes: int = 1

    def __post_init__(self) -> None:
        require(0 < self.eta <= 1, "eta must be in (0, 1]", self.eta)
        require(self.passes >= 1, "passes must be >= 1", self.passes)
        named = self.alpha in ("loo", "previous_pass")
        require(named or isinstance(self.alpha, (int, float)),
                'alpha must be a number, "loo" or "previous_pass"', self.alpha)  # fmt: skip
        require(self.alpha != "loo" or self.points == "iid", 'alpha="loo" needs points="iid"',
                self.points)  # fmt: skip


@dataclass(frozen=True, kw_only=True, slots=True)
class PixelEstimates:
    """Luminances of P pixels."""

    truth: npt.NDArray[np.float64]
    """(P,)"""
    estimates: dict[tuple[Way, int], npt.NDArray[np.float64]]
    """(replicates, P) of every way and number of samples."""


def simulate(
    cache: VisibilityMapCache,
    ways: Sequence[Way],
    samples: Sequence[int],
    *,
    camera: str | int | _core.Camera | None = None,
    size: tuple[int, int] = (640, 480),
    n_pixels: int = 256,
    replicates: int = 32,
    seed: int = 0,
    threads: int | None = None,
) -> PixelEstimates:
    """Estimate random pixels of a picture, independently and many times.

    Parameters
    ----------
    cache : VisibilityMapCache
        Of a scene that `viscache.scenes.light_product` takes; stays as it is.
    ways : sequence of Way
    samples : sequence of int >= 1
        Per pixel and pass.
    size : (width, height)
        Of the picture: pixels decide how far records are looked for.
    n_pixels : int >= 1
        Drawn from those that see a surface, all of them if there are fewer.
    replicates : int >= 2

    Raises
    ------
    ValueError
        A parameter out of range, or a scene with other lights.
    """
    require(n_pixels >= 1, "n_pixels must be >= 1", n_pixels)
    require(replicates >= 2, "replicates must be >= 2", replicates)
    _, texels = environment_texels(cache.scene)
    light = _core.vismap.EnvironmentPyramid(texels)
    truth: list[float] = []
    found: dict[tuple[Way, int], list[Floats]] = {(w, n): [] for w in ways for n in samples}
    for number, pixel in enumerate(_pixels(cache, camera, size, n_pixels, seed)):
        truth.append(pixel.truth(texels))
        points = {eta: pixel.estimate(light, eta) for eta in {way.eta for way in ways}}
        for way, n in found:
            made = points[way.eta].simulate(
                pixel.visible, n=n, passes=way.passes, replicates=replicates,
                set=_core.PointSet.INDEPENDENT if way.points == "iid" else _core.PointSet.ZERO_TWO,
                mode=_mode(way), alpha=_number(way), seed=seed + number,
                threads=checked_threads(threads),
            )  # fmt: skip
            found[way, n].append(made[:, -1] @ LUMINANCE)
    return PixelEstimates(
        truth=np.array(truth), estimates={k: np.stack(v, axis=1) for k, v in found.items()}
    )


@dataclass(frozen=True, kw_only=True, slots=True)
class _Pixel:
    """What is known of one pixel, over the texels and over the cells of its maps."""

    b: npt.NDArray[np.float32]  # (R, R, 3)
    visible: Bools  # (R, R)
    maps: Bools  # (n, 2^m, 2^m)
    beta: npt.NDArray[np.float32]  # (n,)
    dilated: list[Bools]

    def truth(self, texels: Floats) -> float:
        light = (texels.astype(float) * self.b)[self.visible].sum(axis=0) @ LUMINANCE
        return float(light * 4 * np.pi / self.visible.size)

    def estimate(self, light: Any, eta: float) -> Any:
        return _core.vismap.PointEstimate(
            light, self.b, self.maps, self.beta, dilated=self.dilated, eta=eta
        )


def _pixels(
    cache: VisibilityMapCache, camera: Any, size: tuple[int, int], n_pixels: int, seed: int
) -> Iterator[_Pixel]:
    scene, m = cache.scene, cache.settings.m
    view = find_camera(scene, camera)
    directions, texels = environment_texels(scene)
    edge = len(texels)
    hits = first_hits(scene, view, size)
    rules = _core.vismap.PixelRules(cache.settings.d_max)
    asking, _, _ = _core.vismap.pixel_points(
        scene._core, scene.caster(), view, *size, (0.5, 0.5), rules
    )
    there = np.flatnonzero((asking.d_max > 0) & (hits.materials >= 0))
    rng = np.random.Generator(np.random.PCG64(seed))
    chosen = np.sort(rng.permutation(there)[:n_pixels])
    lookup = cache.lookup(asking.positions[chosen], asking.normals[chosen], asking.d_max[chosen])
    bits = cache.records().bits
    for row, pixel in enumerate(chosen):
        b = reflected(scene, hits, pixel, directions).astype(np.float32)
        maps, beta, dilated = _blended(lookup, row, bits, m)
        yield _Pixel(
            b=b.reshape(edge, edge, 3),
            visible=_visible(scene, hits.starts[pixel], hits.normals[pixel], directions),
            maps=maps, beta=beta, dilated=dilated,
        )  # fmt: skip


def _visible(scene: Scene, start: Floats, normal: Floats, directions: Floats) -> Bools:
    above = directions @ normal > 0
    seen = np.zeros(len(directions), bool)
    seen[above] = ~scene.occluded(np.broadcast_to(start, (int(above.sum()), 3)), directions[above])
    edge = round(len(directions) ** 0.5)
    return seen.reshape(edge, edge)


def _blended(
    lookup: Lookup, row: int, bits: npt.NDArray[np.uint64], m: int
) -> tuple[Bools, npt.NDArray[np.float32], list[Bools]]:
    """Maps of a looked-up point, their shares, and what grew from them (V^1, V^2, V^3)."""
    speaks = lookup.beta[row] > 0
    words = [bits[i] for i in lookup.ids[row][speaks]]
    grown = 3 if m >= 6 else 2
    if not words:
        return np.zeros((0, 1 << m, 1 << m), bool), np.zeros(0, np.float32), []
    dilated = [
        np.stack([_as_image(_core.vismap.dilated(w, m, level), m - level + 1) for w in words])
        for level in range(1, grown + 1)
    ]
    return np.stack([_as_image(w, m) for w in words]), lookup.beta[row][speaks], dilated


def _as_image(words: npt.NDArray[np.uint64], m: int) -> Bools:
    """A map's cells, row by row, from its words in Z order."""
    axis = np.arange(1 << m, dtype=np.uint32)
    z = _core.vismap.morton2(*np.meshgrid(axis, axis)).astype(np.int64)
    return np.asarray((words[z // 64] >> (z % 64).astype(np.uint64) & np.uint64(1)) > 0)


def _mode(way: Way) -> Any:
    modes = {"loo": _core.AlphaMode.LEAVE_ONE_OUT, "previous_pass": _core.AlphaMode.PREVIOUS_PASS}
    return modes.get(str(way.alpha), _core.AlphaMode.FIXED)


def _number(way: Way) -> float:
    return 1.0 if isinstance(way.alpha, str) else float(way.alpha)

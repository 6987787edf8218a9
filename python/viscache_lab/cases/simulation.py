"""Repeated estimates of single pixels with known true visibility.

Light, reflection and visibility are constant inside each texel of the environment, so that the true
value is a sum and no reference image is needed. Reflection and visibility are those of the scene at
the centres of the texels.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal, TypeAlias

import numpy as np
import numpy.typing as npt

from viscache.scene.cameras import Camera
from viscache.settings.checks import checked_threads, require
from viscache.vismap import VisibilityMapCache
from viscache.vismap.equations import AlphaMode, PointSet
from viscache_lab.cases.light_product import LUMINANCE
from viscache_lab.cases.simulated_pixels import Pixel, Pixels, pooled_alphas

Alpha: TypeAlias = float | Literal["loo", "previous_pass", "oracle"]

#: Size of the first pass of a frame with few samples, and minimum size of a pass.
FIRST_PASS = 10
#: Offset from the seeds of estimates, which count up from the given seed.
PILOT_SEED = 1 << 40


@dataclass(frozen=True, kw_only=True, slots=True)
class Way:
    """A method to estimate a pixel.

    `alpha` is the coefficient of the control variate: 1 as in the paper, 0 for plain product
    sampling; "oracle": the best for independent points, by summation over the true visibility.
    `eta` in (0, 1] is the minimum of the guided density; 1: product sampling. Points are
    independent, or a randomised (0,2)-sequence.

    Only the last of the passes counts; with "previous_pass", α comes from the others. If
    `one_shot`, the given samples are all samples of the pixel: with "previous_pass" they are
    divided as in `one_shot_passes`, and the mean of all passes counts. `first` is the α of the
    first pass: 1 as in the paper, or pooled from 16 samples at 1000 random pixels.
    """

    alpha: Alpha = 0.0
    eta: float = 1.0
    points: Literal["iid", "rqmc"] = "rqmc"
    passes: int = 1
    one_shot: bool = False
    first: Literal["one", "pilot"] = "one"

    def __post_init__(self) -> None:
        require(0 < self.eta <= 1, "eta must be in (0, 1]", self.eta)
        require(self.passes >= 1, "passes must be >= 1", self.passes)
        named = self.alpha in ("loo", "previous_pass", "oracle")
        fits = named or isinstance(self.alpha, (int, float))
        require(fits, 'alpha must be a number, "loo", "previous_pass" or "oracle"', self.alpha)
        fits = self.alpha != "loo" or self.points == "iid"
        require(fits, 'alpha="loo" needs points="iid"', self.points)
        once = not self.one_shot or self.passes == 1
        require(once, "passes must be 1 with one_shot", self.passes)
        require(self.first in ("one", "pilot"), 'first must be "one" or "pilot"', self.first)
        by_passes = self.alpha == "previous_pass" or not (self.one_shot or self.first == "pilot")
        require(
            by_passes, 'alpha must be "previous_pass" with one_shot or first="pilot"', self.alpha
        )

    def sizes(self, samples: int) -> list[int]:
        """Number of samples of every pass."""
        return one_shot_passes(samples) if self.one_shot else [samples] * self.passes


@dataclass(frozen=True, kw_only=True, slots=True)
class PixelEstimates:
    """Luminances of P pixels."""

    truth: npt.NDArray[np.float64]
    """(P,)"""
    estimates: dict[tuple[Way, int], npt.NDArray[np.float64]]
    """(replicates, P) for every method and number of samples."""


def one_shot_passes(samples: int) -> list[int]:
    """Division of the samples of a single frame: 10, 20, 40, …, the rest; no pass below ten.

    Examples
    --------
    >>> one_shot_passes(10), one_shot_passes(30), one_shot_passes(100)
    ([10], [10, 20], [10, 20, 40, 30])
    """
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
                mode=_mode(way),
                alpha=_alpha(way, pixel, point, first),
                seed=seed + number,
                threads=checked_threads(threads),
            )
            found[way, n].append(_counts(made @ LUMINANCE, way, sizes))
    return PixelEstimates(
        truth=np.array(truth), estimates={k: np.stack(v, axis=1) for k, v in found.items()}
    )


def _counts(
    passes: npt.NDArray[np.float64], way: Way, sizes: list[int]
) -> npt.NDArray[np.floating[Any]]:
    """The result of the passes (replicates, passes): the last pass, or the mean of all samples."""
    return passes @ np.array(sizes) / sum(sizes) if way.one_shot else passes[:, -1]


def _points(kind: str) -> Any:
    return PointSet.INDEPENDENT if kind == "iid" else PointSet.ZERO_TWO


def _mode(way: Way) -> Any:
    modes = {"loo": AlphaMode.LEAVE_ONE_OUT, "previous_pass": AlphaMode.PREVIOUS_PASS}
    return modes.get(str(way.alpha), AlphaMode.FIXED)


def _alpha(way: Way, pixel: Pixel, point: Any, first: Mapping[tuple[float, str], float]) -> float:
    """The given α, or that of the first pass."""
    if way.alpha == "oracle":
        return pixel.oracle_alpha(point)
    if isinstance(way.alpha, str):
        return first[way.eta, way.points] if way.first == "pilot" else 1.0
    return float(way.alpha)

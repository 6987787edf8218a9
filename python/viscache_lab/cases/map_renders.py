"""Two renderers to compare: product sampling, and product sampling with visibility maps."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

import viscache as vc
from viscache.metrics.variance import VarianceRatio, variance_ratio
from viscache_lab.cases.simulation import PixelEstimates, Way

#: The time of product sampling is measured at these numbers of samples.
CALIBRATED = (20, 80)
Images = list[npt.NDArray[np.floating[Any]]]


@dataclass(frozen=True, kw_only=True, slots=True)
class Picture:
    """A scene's picture with rays through pixel centres, so that only light samples vary."""

    scene: vc.Scene
    size: tuple[int, int]
    camera: int = 0

    def build_cache(self, settings: vc.MapSettings | None = None) -> vc.VisibilityMapCache:
        """A cache with records for every pixel."""
        cache = vc.VisibilityMapCache(self.scene, settings)
        cache.update(self.camera, size=self.size)
        return cache

    def product(self, samples: int, seed: int = 0) -> vc.Frame:
        """A frame with product sampling only."""
        return self.maps(samples, None, seed)

    def maps(self, samples: int, visibility: vc.VisMaps | None, seed: int = 0) -> vc.Frame:
        """A frame with maps."""
        light = vc.Direct(environment="product", n_environment=samples, centred=True)
        return self._frame(light, seed, visibility=visibility)

    def dealt(self, directions: int, sets: int, seed: int = 0) -> vc.Frame:
        """A frame with directions that all eye points share, one eye point for each set."""
        light = vc.Direct(environment="shared", n_environment=directions, centred=True)
        return self._frame(replace(light, interleave=sets), seed, spp=sets)

    def _frame(self, light: vc.Direct, seed: int, **more: Any) -> vc.Frame:
        where: dict[str, Any] = {"camera": self.camera, "size": self.size, "seed": seed}
        return vc.render(self.scene, light, **where, **more)


def paper_maps(cache: vc.VisibilityMapCache | None) -> vc.VisMaps:
    """The paper's estimator: α = 1, no guiding. A given cache is not updated."""
    return vc.VisMaps(cache=cache, update=cache is None, alpha="one", sampling="product")


def images(make: Callable[[int], vc.Frame], seeds: Sequence[int]) -> Images:
    """Independent renders."""
    return [make(seed).image for seed in seeds]


def variance_left(found: PixelEstimates, way: Way, base: Way, n: int) -> VarianceRatio:
    """The variance of simulated pixels with n samples, of one way over another."""
    ours, theirs = ([r[None, :, None] for r in found.estimates[w, n]] for w in (way, base))
    return variance_ratio(ours, theirs)


def cpu_median(frames: list[vc.Frame]) -> float:
    """Median CPU seconds of all threads."""
    return float(np.median([frame.timings["cpu_s"] for frame in frames]))


def samples_in(picture: Picture, seconds: float) -> int:
    """Number of samples of product sampling in a given time, from a line through two times."""
    low, high = (cpu_median([picture.product(n) for _ in range(3)]) for n in CALIBRATED)
    slope = max((high - low) / (CALIBRATED[1] - CALIBRATED[0]), 1e-9)
    return max(1, round(CALIBRATED[0] + (seconds - low) / slope))

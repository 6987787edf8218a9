"""Pairs of renderers that figures compare: product sampling, and the same with visibility maps."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from viscache.frame import Frame
from viscache.render import render
from viscache.scene import Scene
from viscache.settings.integrators import Direct
from viscache.settings.visibility import VisMaps
from viscache.vismap import MapSettings, VisibilityMapCache

__all__ = ["Picture", "images", "paper_maps"]

Images = list[npt.NDArray[np.floating[Any]]]


@dataclass(frozen=True, kw_only=True, slots=True)
class Picture:
    """A scene's picture at one size, with rays through the middles of pixels: only light varies."""

    scene: Scene
    size: tuple[int, int]
    camera: int = 0

    def build_cache(self, settings: MapSettings | None = None) -> VisibilityMapCache:
        """A cache that every pixel was given its records in."""
        cache = VisibilityMapCache(self.scene, settings)
        cache.update(self.camera, size=self.size)
        return cache

    def product(self, samples: int, seed: int = 0) -> Frame:
        """Product sampling alone."""
        return self._frame(samples, seed, None)

    def maps(self, samples: int, visibility: VisMaps, seed: int = 0) -> Frame:
        """With maps."""
        return self._frame(samples, seed, visibility)

    def _direct(self, samples: int) -> Direct:
        return Direct(environment="product", n_environment=samples, centred=True)

    def _frame(self, samples: int, seed: int, visibility: VisMaps | None) -> Frame:
        return render(self.scene, self._direct(samples), visibility=visibility, camera=self.camera,
                      size=self.size, seed=seed)  # fmt: skip


def paper_maps(cache: VisibilityMapCache | None) -> VisMaps:
    """The paper's estimator: α = 1, no guiding. With a cache, it stays as it is."""
    return VisMaps(cache=cache, update=cache is None, alpha="one", sampling="product")


def images(make: Callable[[int], Frame], seeds: Sequence[int]) -> Images:
    """Independent renders."""
    return [make(seed).image for seed in seeds]

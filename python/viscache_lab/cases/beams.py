"""Rays of one kind, traced by one thread."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Literal, TypeAlias

import numpy as np
import numpy.typing as npt

import viscache as vc
from viscache.scene.about import sphere

Floats: TypeAlias = npt.NDArray[np.float32]
Job: TypeAlias = Literal["any", "nearest"]


@dataclass(frozen=True, kw_only=True, slots=True)
class Beams:
    """Rays of one job: any hit or nearest hit."""

    origins: Floats
    directions: Floats
    job: Job = "nearest"

    def __len__(self) -> int:
        return len(self.origins)

    def some(self, n: int) -> Beams:
        """About n evenly spread rays, in runs of 16 neighbours."""
        if len(self) <= n:
            return self
        first = np.linspace(0, len(self) - 16, max(1, n // 16)).astype(np.int64)
        pick = (first[:, None] + np.arange(16)).ravel()
        return Beams(origins=self.origins[pick], directions=self.directions[pick], job=self.job)

    def trace(self, caster: Any) -> npt.NDArray[Any]:
        """The results of one thread: blocked or not, or distances."""
        if self.job == "any":
            return np.asarray(caster.occluded(self.origins, self.directions, math.inf, 1))
        return np.asarray(caster.intersect(self.origins, self.directions, 1)[0])


def chords(scene: vc.Scene, n: int) -> Beams:
    """Rays between random points of the scene's bounding sphere."""
    rng = np.random.default_rng(5)
    ends = rng.normal(size=(2, n, 3))
    ends /= np.linalg.norm(ends, axis=2, keepdims=True)
    center, radius = sphere(scene)
    o, e = ends * radius + center
    return Beams(origins=o.astype(np.float32), directions=(e - o).astype(np.float32))

"""Errors of frames against a converged picture, and error times time of two ways."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from viscache_lab.experiment.amounts import figure

__all__ = ["Errors", "energy_z", "gain", "gain_figure"]

Array = npt.NDArray[Any]

#: Floor of the relative error, as a share of the picture's mean.
DARK = 0.05
BOOTSTRAP = 1000


class Errors:
    """Squared errors of frames against the mean of other frames, whose own noise is taken out."""

    def __init__(self, converged: Array) -> None:
        self.picture = converged.mean(axis=0)
        self.noise = converged.var(axis=0, ddof=1) / len(converged)
        self.mean = float(self.picture.mean())

    def of(self, images: Array) -> tuple[Array, Array]:
        """Relative to the squared mean of the picture, and to each pixel; one value per frame."""
        square = np.square(images - self.picture) - self.noise
        floor = (DARK * self.mean) ** 2
        relative = square / (np.square(self.picture) + floor)
        return square.mean(axis=(1, 2, 3)) / self.mean**2, relative.mean(axis=(1, 2, 3))


def seed_by_seed(
    ways: dict[str, Callable[[int], tuple[Array, float]]], seeds: int
) -> tuple[dict[str, Array], dict[str, list[float]]]:
    """Images and CPU seconds of ways that take turns; each gives both for a seed."""
    images: dict[str, list[Array]] = {way: [] for way in ways}
    seconds: dict[str, list[float]] = {way: [] for way in ways}
    for seed in range(seeds):
        for way in ways if seed % 2 else reversed(ways):
            image, spent = ways[way](seed)
            images[way].append(image)
            seconds[way].append(spent)
    return {way: np.stack(stack) for way, stack in images.items()}, seconds


def energy_z(ours: Array, exact: Array) -> float:
    """Student's t of the difference of the frames' means, paired by seeds."""
    differences = (ours - exact).mean(axis=(1, 2, 3))
    noise = float(differences.std(ddof=1)) / math.sqrt(len(differences))
    return float(differences.mean()) / max(noise, 1e-30)


def gain(
    found: Mapping[str, tuple[Array, Array]],
    seconds: Mapping[str, list[float]],
    way: str,
    number: int,
    base: str = "exact",
) -> tuple[float, float, float]:
    """Error times seconds of the base over that of the other way, with its 95 % interval.

    `number` chooses the error: 0 relative to the squared mean of the picture, 1 to each pixel.
    """
    rows = np.stack([found[base][number], seconds[base], found[way][number], seconds[way]], axis=1)
    chosen = np.random.default_rng(0).integers(0, len(rows), (BOOTSTRAP, len(rows)))
    means = np.concatenate([rows.mean(axis=0, keepdims=True), rows[chosen].mean(axis=1)])
    gains = means[:, 0] * means[:, 1] / np.maximum(means[:, 2] * means[:, 3], 1e-30)
    low, high = np.quantile(gains[1:], [0.025, 0.975])
    return float(gains[0]), float(low), float(high)


def gain_figure(
    name: str,
    found: Mapping[str, tuple[Array, Array]],
    seconds: Mapping[str, list[float]],
    way: str,
    base: str = "exact",
    goal: float | None = None,
) -> dict[str, Any]:
    """The gain of a way over the base by both errors, with errors and seconds of the two."""
    ratio, low, high = gain(found, seconds, way, 0, base)
    relative = gain(found, seconds, way, 1, base)
    nmse, base_nmse = (float(found[w][0].mean()) for w in (way, base))
    spent, base_spent = (float(np.mean(seconds[w])) for w in (way, base))
    return figure(
        name,
        nmse * spent,
        "nMSE·s",
        baseline=base_nmse * base_spent,
        ratios=sorted([low, ratio, high]),
        goal=goal,
        gain_rel=relative[0],
        rel_low=relative[1],
        rel_high=relative[2],
        nmse=nmse,
        base_nmse=base_nmse,
        seconds=spent,
        base_seconds=base_spent,
    )

"""Errors of frames and passes: beside converged pictures, over time, and those that stay."""

from __future__ import annotations

import math
import statistics
from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType
from typing import Any

import numpy as np
import numpy.typing as npt

import viscache as vc
from viscache.metrics import confidence_interval
from viscache_lab.experiment import Trial
from viscache_lab.experiment.amounts import figure, student_t

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


#: Seeds of frames of a converged picture start here.
FIRST_REFERENCE = 1000
#: The largest |z| of the energy of a way without bias against the first of the same seeds.
MOST_Z = 4.0
#: What ratios of `error_over_time` mean; the base's name goes first.
NOTE = (
    "Ratios: mean squared error times CPU seconds, {} over the other, with the 95 %"
    " interval of a bootstrap over seeds. Values: the same of the other, relative to the"
    " squared mean. gain_rel: by squared errors relative to each pixel, floor 5 % of the mean."
)


def error_over_time(
    trial: Trial,
    name: str,
    ways: dict[str, Callable[[int], tuple[Array, float]]],
    converged: Callable[[int], tuple[Array, float]],
    *,
    seeds: int,
    references: int,
    goals: Mapping[str, float] = MappingProxyType({}),
    biased: Sequence[str] = (),
) -> None:
    """Gains of ways over the first, which take turns seed by seed.

    A way gives the image and CPU seconds of a seed; so does `converged`, whose mean is the
    converged picture. `goals` are least gains. `biased` ways have another energy than the first.
    """
    first = range(FIRST_REFERENCE, FIRST_REFERENCE + references)
    errors = Errors(np.stack([converged(seed)[0] for seed in first]))
    for render in ways.values():
        render(0)
    taken: dict[str, list[tuple[Array, float]]] = {way: [] for way in ways}
    for seed in range(seeds):
        for way in ways if seed % 2 else reversed(ways):
            taken[way].append(ways[way](seed))
    images = {way: np.stack([image for image, _ in made]) for way, made in taken.items()}
    seconds = {way: [spent for _, spent in made] for way, made in taken.items()}
    found = {way: errors.of(stack) for way, stack in images.items()}
    base, *others = ways
    for way in others:
        what = f"{name}: {way} vs {base}"
        trial.figures.append(gain_figure(what, found, seconds, way, base, goals.get(way)))
        if way not in biased:
            z = energy_z(images[way] - images[base])
            trial.check(f"{name}: {way}, |z| of the energy", abs(z), MOST_Z)


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
    base: str,
    goal: float | None,
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


#: Edge of the blocks of pixels between which the standard error is taken.
BIAS_BLOCK = 16
#: First passes of the two pictures: other blocks of samples.
FIRST = (0, 512)


def differences(
    scene: vc.Scene, light: Any, caches: dict[Any, Any], size: tuple[int, int], passes: int
) -> tuple[dict[str, Array], float]:
    """By use of a cache: passes minus exact ones of the same eye samples; and the mean light.

    The arrays are (pass, row, column, channel): of two pictures, half each, with what each learns
    from its first passes. Their draws are independent.
    """

    def both(visibility: Any, use: Any = None) -> Array:
        pictures = [
            vc.Progressive(scene, light, visibility=visibility, use=use, first_pass=n, size=size)
            for n in FIRST
        ]
        return np.concatenate([alone(p, passes // 2) for p in pictures])

    exact = both("exact")
    found = {use: both(cache, use) - exact for use, cache in caches.items()}
    return found, float(exact.mean())


def alone(picture: vc.Progressive, passes: int) -> Array:
    """Each pass by itself."""
    sums = [picture.passes(1).image.astype(np.float64) * (i + 1) for i in range(passes)]
    return np.diff(np.stack([np.zeros_like(sums[0]), *sums]), axis=0)


def energy_z(found: Array) -> float:
    """The mean difference of the energy of frames in its standard errors."""
    return student_t(found.mean(axis=(1, 2, 3)))


def persistent_z(found: Array, light: float) -> tuple[float, float]:
    """Squared bias of pixels over the squared mean light, and how many standard errors it is.

    The first half times the second: their noise is independent, and what both have is the bias.
    """
    half = len(found) // 2
    product = found[:half].mean(axis=0) * found[half:].mean(axis=0) / light**2
    h, w = (n // BIAS_BLOCK for n in product.shape[:2])
    cut = product[: h * BIAS_BLOCK, : w * BIAS_BLOCK].reshape(h, BIAS_BLOCK, w, BIAS_BLOCK, -1)
    blocks = cut.mean(axis=(1, 3, 4)).ravel()
    return float(blocks.mean()), student_t(blocks)


def log_interval(ratios: Sequence[float]) -> tuple[float, float, float]:
    """Geometric mean of independent ratios, and Student's 95 % interval of its logarithm."""
    if len(ratios) < 2 or not all(r > 0 and math.isfinite(r) for r in ratios):
        raise ValueError(f"ratios must be two or more finite numbers > 0, got {list(ratios)}")
    logs = [math.log(r) for r in ratios]
    low, high = confidence_interval(logs)
    return math.exp(statistics.fmean(logs)), math.exp(low), math.exp(high)

"""Ratio of the variances of two renderers, from independent renders."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from viscache.base.tonemap import luminance
from viscache.settings.checks import require

__all__ = ["VarianceRatio", "variance_ratio"]

Images = Sequence[npt.NDArray[np.floating[Any]]]
Planes = npt.NDArray[np.float64]

#: Number of bootstrap samples.
BOOTSTRAP = 2000
#: Share of pixels with the largest variances that `trimmed` excludes.
TRIMMED_SHARE = 1e-3


@dataclass(frozen=True, kw_only=True, slots=True)
class VarianceRatio:
    """How much of the baseline's variance is left."""

    ratio: float
    """Σ variance / Σ variance over pixels, of linear luminance."""
    low: float
    """Lower end of the 95 % interval of `ratio`, by bootstrap over renders."""
    high: float
    """Its upper end."""
    trimmed: float
    """The ratio without the thousandth of the pixels that varies most in both together."""
    worse_share: float
    """Share of the pixels in which the baseline varies less."""
    renders: tuple[int, int]
    """Of ours and of the baseline."""
    energy: float
    """(Σ ours − Σ baseline) / Σ baseline of the means: about 0 if both are unbiased."""
    energy_z: float
    """The same over its standard error."""

    @property
    def gains(self) -> list[float]:
        """Baseline over ours: lower end, value, upper end; 10¹² if our variance is 0."""
        return [1 / max(left, 1e-12) for left in (self.high, self.ratio, self.low)]


def variance_ratio(
    ours: Images, baseline: Images, *, pixels: npt.NDArray[np.bool_] | None = None, seed: int = 0
) -> VarianceRatio:
    """Compare independent renders of one picture by two unbiased renderers.

    Parameters
    ----------
    ours, baseline : sequences of at least 2 (H, W, 3) float images
        Renders with different seeds, of the same size.
    pixels : (H, W) bool, optional
        Only these pixels.
    seed : int
        Seed of the bootstrap.

    Raises
    ------
    ValueError
        Fewer than two renders, different sizes, values that are not finite, or a baseline without
        variance.

    Notes
    -----
    The variance of a pixel is the variance over renders (ddof = 1), so no reference is needed. The
    interval is a bootstrap: it draws renders of each side with replacement, and skips draws
    without variance of the baseline. It is too narrow for less than eight renders.
    """
    a, b = _planes(ours, "ours", pixels), _planes(baseline, "baseline", pixels)
    require(a.shape[1] == b.shape[1], "renders must have the same pixels", (a.shape[1], b.shape[1]))
    variance_a, variance_b = a.var(axis=0, ddof=1), b.var(axis=0, ddof=1)
    total = float(variance_b.sum())
    require(total > 0, "baseline must vary", total)
    rng = np.random.Generator(np.random.PCG64(seed))
    drawn_a, drawn_b = _resampled_sums(a, rng), _resampled_sums(b, rng)
    varying = drawn_b > 1e-9 * total
    low, high = np.quantile(drawn_a[varying] / drawn_b[varying], (0.025, 0.975))
    both = variance_a + variance_b
    kept = np.argsort(both, kind="stable")[: max(1, int(len(both) * (1 - TRIMMED_SHARE)))]
    sums_a, sums_b = a.sum(axis=1), b.sum(axis=1)
    difference = sums_a.mean() - sums_b.mean()
    error = np.sqrt(sums_a.var(ddof=1) / len(a) + sums_b.var(ddof=1) / len(b))
    return VarianceRatio(
        ratio=float(variance_a.sum()) / total,
        low=float(low),
        high=float(high),
        trimmed=float(variance_a[kept].sum() / max(variance_b[kept].sum(), 1e-300)),
        worse_share=float((variance_a > variance_b).mean()),
        renders=(len(a), len(b)),
        energy=float(difference / sums_b.mean()),
        energy_z=float(difference / error) if error > 0 else 0.0,
    )


def _planes(images: Images, name: str, pixels: npt.NDArray[np.bool_] | None) -> Planes:
    """Luminance (renders, pixels)."""
    require(len(images) >= 2, f"{name} must be at least 2 renders", len(images))
    shapes = {np.shape(image) for image in images}
    require(len(shapes) == 1, f"{name} must have one size", sorted(shapes))
    planes = np.stack([luminance(np.asarray(image)) for image in images])
    if pixels is not None:
        require(
            pixels.shape == planes.shape[1:],
            "pixels must have the size of the renders",
            pixels.shape,
        )
        require(bool(pixels.any()), "pixels must hold one pixel at least", 0)
        chosen: Planes = planes[:, pixels]
    else:
        chosen = planes.reshape(len(planes), -1)
    require(bool(np.isfinite(chosen).all()), f"{name} must be finite", "values that are not")
    return chosen


def _resampled_sums(planes: Planes, rng: np.random.Generator) -> Planes:
    """Σ variance over pixels for renders drawn with replacement, (BOOTSTRAP,).

    With render i drawn w_i times, Σ (x − mean)² = Σ w_i G_ii − wᵀ G w / n, G = x xᵀ over pixels.
    """
    n = len(planes)
    centred = planes - planes.mean(axis=0)
    gram = centred @ centred.T
    drawn = rng.integers(0, n, (BOOTSTRAP, n))
    drawn[:, 1] += (drawn == drawn[:, :1]).all(axis=1)  # one render has no variance: take two
    weights = np.stack([(drawn % n == k).sum(axis=1) for k in range(n)], axis=1).astype(float)
    sums: Planes = weights @ np.diag(gram) - ((weights @ gram) * weights).sum(axis=1) / n
    # Unbiased with weights: renders drawn twice count for less
    return np.asarray(np.maximum(sums, 0) / (n - (weights**2).sum(axis=1) / n))

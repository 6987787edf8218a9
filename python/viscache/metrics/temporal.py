"""Changes of frames over time, and the part of them that a cache causes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from viscache.base import tonemap
from viscache.frame import Frame
from viscache.settings.checks import require

__all__ = ["Flicker", "flicker", "mean_temporal_variance", "seen"]

Plane = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Flicker:
    """Variances over the frames of a sequence, averaged over pixels; white is 1."""

    cached: float
    """Of the pictures."""
    exact: float
    """Of the reference's: what moves moves."""
    error: float
    """Of the difference between both: 0 for an error that stands still."""

    @property
    def above(self) -> float:
        """Temporal variance minus that of the reference. Negative if the cache misses motion."""
        return self.cached - self.exact


def flicker(
    frames: Sequence[Frame], references: Sequence[Frame], *, exposure: float | None = None
) -> Flicker:
    """Temporal variance of cached frames and of exact frames.

    Parameters
    ----------
    frames, references : sequences of Frame, of one length >= 2
        The same views in the same order, with a cache and exact.
    exposure : float, optional
        Factor of the luminance, before it is clipped at 1. By default the 95th percentile of the
        first reference becomes white.

    Returns
    -------
    Flicker
    """
    equal = len(frames) == len(references) >= 2
    require(
        equal,
        "frames and references must be equally many, at least 2",
        (len(frames), len(references)),
    )
    if exposure is None:
        exposure = tonemap.auto_exposure(references[0].image, 95.0)
    cached, exact = ([seen(f, exposure) for f in some] for some in (frames, references))
    return Flicker(
        mean_temporal_variance(cached),
        mean_temporal_variance(exact),
        mean_temporal_variance([a - b for a, b in zip(cached, exact, strict=True)]),
    )


def seen(frame: Frame, exposure: float) -> Plane:
    """Luminance as a screen shows it, before its curve: exposed, white clipped."""
    shown: Plane = np.clip(exposure * tonemap.luminance(frame.image), 0, 1)
    return shown


def mean_temporal_variance(planes: list[Plane]) -> float:
    """Mean over pixels of the unbiased variance over frames."""
    return float(np.var(np.stack(planes), axis=0, ddof=1).mean())

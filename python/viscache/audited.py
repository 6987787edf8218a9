"""The error of a cached frame, estimated from the few pixels that exact rays answered as well."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from viscache.emitted_light import light_on_surfaces

__all__ = ["LARGE_ERROR", "EstimatedError", "error_warnings", "estimated_error"]

#: An error over light on surfaces that frames are warned of.
LARGE_ERROR = 0.05
#: From fewer pixels the interval says nothing.
LEAST_PIXELS = 100
#: Standard errors to either side of a 95 % interval.
WIDTH_95 = 1.96


@dataclass(frozen=True, slots=True)
class EstimatedError:
    """An estimate of `rel_l1_reflected` with its 95 % interval.

    Attributes
    ----------
    value, low, high : float
    pixels : int
        Number of audited pixels.
    group : str
        The light group with the largest share.
    """

    value: float
    low: float
    high: float
    pixels: int
    group: str


def estimated_error(frame: Any) -> EstimatedError | None:
    """The estimate from `frame.counters["audit"]`; None without an audit, or without light.

    One pixel of each block of 16 × 16, or of larger blocks in pictures above 256², is audited. Its
    error stands for the block. The light on surfaces is that of the whole frame. The interval is
    symmetric in the logarithm, as the errors of few pixels make up most of the sum.
    """
    audit: Mapping[str, Any] | None = frame.counters.get("audit")
    surfaces = light_on_surfaces(frame)
    if audit is None or surfaces is None:
        return None
    light, pixels = float(np.abs(surfaces).sum()), int(audit["pixels"])
    if light <= 0 or pixels < LEAST_PIXELS:
        return None
    error = float(audit["error"])
    spread = math.sqrt(max(0.0, audit["square"] - error**2 / pixels))
    factor = math.exp(WIDTH_95 * spread / error) if error > 0 else 1.0
    value = error / light
    group = max(audit["groups"], key=audit["groups"].__getitem__)
    return EstimatedError(value, value / factor, value * factor, pixels, group)


def error_warnings(frame: Any) -> list[str]:
    """A warning where the estimated error may be above `LARGE_ERROR`."""
    found = estimated_error(frame)
    if found is None or found.high <= LARGE_ERROR:
        return []
    return [
        f"the cache errs by about {found.value:.1%} of the light on surfaces (95 % interval"
        f" {found.low:.1%} to {found.high:.1%}, from {found.pixels} pixels traced exactly), most of"
        f" it in light group {found.group!r}: use a smaller c_finest or c_e,"
        f" exact_groups=({found.group!r},), or vc.Exact()"
    ]

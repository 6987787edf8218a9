"""What corrections learn from the first passes of a picture, for later ones."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from viscache import _core
from viscache.oracles.correct import Correct
from viscache.settings.aqvc import LIGHT_GROUPS

#: Classes of answers of each light group.
N_CLASSES = 8
#: The share of a class reaches 1 at `certain` · 2^(octave - 1). Octave 1 is for answers of which
#: one in six is wrong.
PLAIN_OCTAVE, MOST_OCTAVES = 1, 4
PLAIN_WRONG = 0.16
#: Checked answers of a class below which its share stays that of the worst.
LEAST_CHECKED = 64
#: Passes that tell how shares should be; their draws are independent of all later ones.
LEARNING_PASSES = 2
#: Shares are multiplied by one of these powers of two.
LEAST_SCALE, MOST_SCALE = 0.5, 16.0
#: Cost of a look-up and of a ray for a single query, in exact rays of whole rows.
LOOK_UP, SINGLE_RAY = 0.02, 2.0
#: Pixels of the greatest other noise are left out: edges of lamps, which would hide all else.
LEFT_OUT = 0.05
#: Other noise of sixteen passes over that of as many independent ones: their samples are well
#: spread over each pixel, so that the noise of edges falls faster than 1/n. With `LEFT_OUT` it was
#: 0.5 in classroom_like and 1.4 in garage; the smaller one, as exact visibility is for good.
WELL_SPREAD = 0.5
#: Where rows are kept, misses of pass n fall with 1/n: those of passes 3 to 16 over those of the
#: first two, per pass.
LATER_MISSES = 0.18
#: The same over those of the first pass alone: the second has a fifth to a quarter of them.
LATER_THAN_FIRST = 0.11


@dataclass(frozen=True)
class Shares:
    """How later passes draw.

    `octaves` (8 light groups of 8 classes) says where the share of corrections reaches 1. `scale`
    is of the shares of all classes; inf: exact visibility costs less for the same error.
    """

    octaves: list[list[int]] | None = None
    scale: float = 1.0


@dataclass(frozen=True)
class PassMemory:
    """What a pass takes over from those before it.

    The first pass fills `lights`, which are shared. `octaves` are as in `Shares`, from passes of
    other epochs, whose draws are independent of this one's: passes of one epoch take turns at the
    samples of a pixel.
    """

    lights: _core.KeptLights
    octaves: list[list[int]] | None = None
    epoch: int = 0


def unlearnt() -> list[list[int]]:
    """Octaves before anything is known."""
    return [[PLAIN_OCTAVE] * N_CLASSES for _ in LIGHT_GROUPS]


def octaves_of(share_by_class: Mapping[str, Any]) -> list[list[int]]:
    """Octaves for the classes of a frame's counters "share_by_class".

    The variance of corrections is least where the share is proportional to c·√p, with p the
    probability of a wrong answer: half an octave of p is one of the share.
    """
    octaves = unlearnt()
    for name, classes in share_by_class.items():
        for k, counted in enumerate(classes.values()):
            if counted["corrections"] < LEAST_CHECKED:
                continue
            p = max(counted["wrong"], 0.5) / counted["corrections"]
            octave = PLAIN_OCTAVE + round(0.5 * math.log2(PLAIN_WRONG / p))
            octaves[LIGHT_GROUPS.index(name)][k] = min(max(octave, 0), MOST_OCTAVES)
    return octaves


def best_scale(
    variance: npt.NDArray[np.float64],
    of_corrections: npt.NDArray[np.float64],
    light: npt.NDArray[np.float64],
    counters: Mapping[str, Any],
    *,
    rows_are_kept: bool = False,
) -> float:
    """The factor of all shares with the least error · cost, or inf for exact visibility.

    Shares times s leave the variance of corrections A/s, and cost s times their rays. With σ² the
    other noise of a pass, (σ² + A/s)·(cost of the cache + s · cost of corrections) is least, and
    must be below σ² · cost of exact rays. If A is 0, the cache with its checks must cost less than
    exact rays. Costs are counted, never timed.

    `variance` (H, W, 3) is that of one pass, by differences between passes; `of_corrections` is
    their part in it. Errors count relative to the mean picture `light`, with 5 % of its mean added.
    The counters are sums over the first two passes. If rows are kept, later passes have fewer
    misses.
    """
    noise = _relative(variance - of_corrections, light)
    kept = noise <= np.quantile(noise, 1 - LEFT_OUT)
    corrections = float(_relative(of_corrections, light).mean())
    # Differences of few passes can be below the part of corrections
    others = WELL_SPREAD * max(float(noise[kept].mean()), 0.02 * corrections)

    return _least_cost(others, corrections, counters, LATER_MISSES if rows_are_kept else 1)


def one_pass_is_enough(
    of_corrections: npt.NDArray[np.float64],
    light: npt.NDArray[np.float64],
    counters: Mapping[str, Any],
    *,
    rows_are_kept: bool = False,
) -> bool:
    """Whether the first pass alone tells that exact visibility costs less for the same error.

    One pass does not tell its noise. But neighbouring pixels differ by their noise and by the
    picture, so their differences bound it from above, and noise speaks for corrections. Where they
    lose even so, a second pass would only pay for the same answer. Arguments are those of
    `best_scale`, of the first pass. Pictures of fewer than three columns tell nothing.
    """
    if light.shape[1] < 3:
        return False
    # x(i-1) - 2 x(i) + x(i+1) of independent noise has six times its variance
    second = light[:, :-2] - 2 * light[:, 1:-1] + light[:, 2:]
    differences = _relative(second**2 / 6, light[:, 1:-1])
    corrections = float(_relative(of_corrections, light).mean())
    others = float(differences[differences <= np.quantile(differences, 1 - LEFT_OUT)].mean())
    later_misses = LATER_THAN_FIRST if rows_are_kept else 1
    return math.isinf(_least_cost(others, corrections, counters, later_misses))


def shares_after(
    passes: int,
    squares: npt.NDArray[np.float64],
    layers: Mapping[str, npt.NDArray[np.float64]],
    counters: Mapping[str, Any],
    use: Correct,
    *,
    rows_are_kept: bool,
) -> Shares | None:
    """How later passes draw, or None where the passes so far do not tell.

    `squares` are the squared deviations of the colour; they, layers and counters are sums over
    passes.
    """
    if "share_by_class" not in counters or "variance" not in layers:
        return None
    color, of_corrections = layers["color"] / passes, layers["variance"] / passes
    scale, tells = 1.0, passes >= LEARNING_PASSES
    if use.certain == "auto" and tells:
        variance = squares / (passes - 1)
        scale = best_scale(variance, of_corrections, color, counters, rows_are_kept=rows_are_kept)
    elif use.certain == "auto" and one_pass_is_enough(
        of_corrections, color, counters, rows_are_kept=rows_are_kept
    ):
        scale, tells = math.inf, True
    if not tells:
        return None
    learned = use.classes == "learned"
    return Shares(octaves_of(counters["share_by_class"]) if learned else None, scale)


def _relative(
    squares: npt.NDArray[np.float64], light: npt.NDArray[np.float64]
) -> npt.NDArray[np.float64]:
    """Means over channels of squared errors relative to the light, with 5 % of its mean added."""
    floor = (0.05 * light.mean()) ** 2 + np.finfo(np.float64).tiny
    relative: npt.NDArray[np.float64] = (squares / (light**2 + floor)).mean(axis=-1)
    return relative


def _least_cost(
    others: float, corrections: float, counters: Mapping[str, Any], later_misses: float
) -> float:
    """The scale of least (noise · cost), or inf where exact visibility has less."""
    groups = counters["groups"].values()
    exact = sum(g["rays"] for g in groups if g["rays"] == g["queries"])
    checks = counters["corrections"]
    misses = max(counters["rays"] - exact - checks, 0)
    cache = LOOK_UP * counters["queries"] + exact + SINGLE_RAY * misses * later_misses
    if corrections == 0:  # nothing was wrong, or all that was has been checked
        dear = checks > 0 and cache + SINGLE_RAY * checks > counters["queries"]
        return math.inf if dear else 1.0
    scales = 2.0 ** np.arange(math.log2(LEAST_SCALE), math.log2(MOST_SCALE) + 1)
    cost = (others + corrections / scales) * (cache + SINGLE_RAY * checks * scales)
    best = int(np.argmin(cost))
    return math.inf if cost[best] > others * counters["queries"] else float(scales[best])

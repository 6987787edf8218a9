"""Bias and variance of a sweep's settings, told apart by the pictures of its repeats.

d is the difference of a frame to the exact one of the same seed, R the number of repeats, D the
mean of d over repeats, all per pixel:

=========  =====================================
variance   s² = Σ(d - D)² / (R - 1), of one frame
bias²      D² - s²/R, as D² itself expects bias² + s²/R
=========  =====================================

Both are means over pixels and channels, over the squared mean of the exact pictures. Their sum is
the expected squared error of one frame. Noise that exact frames have, too, is in neither.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
import numpy.typing as npt

from viscache.passes.over_time import half_width
from viscache.sweeps.store import Store
from viscache.sweeps.table import folder_of

if TYPE_CHECKING:
    import xarray

#: Mean and both ends of its 95 % interval.
Interval: TypeAlias = tuple[float, float, float]
Floats: TypeAlias = npt.NDArray[np.float64]


def bias_and_variance(
    pictures: Sequence[npt.NDArray[Any]], exact: Sequence[npt.NDArray[Any]]
) -> tuple[Interval, Interval]:
    """bias² and variance of pictures (H, W, C) against exact ones of the same seeds.

    At least two of each. Intervals are jackknives over blocks of the picture.
    """
    found = [np.asarray(picture, np.float64) for picture in pictures]
    truth = [np.asarray(picture, np.float64) for picture in exact]
    count = len(found)
    off = [a - b for a, b in zip(found, truth, strict=True)]
    mean: Floats = np.add.reduce(off) / count
    spread: Floats = np.add.reduce([np.square(d - mean) for d in off]) / (count - 1)
    level = float(np.mean([picture.mean() for picture in truth])) ** 2
    return _interval(np.square(mean) - spread / count, level), _interval(spread, level)


def of_sweep(ds: xarray.Dataset) -> dict[tuple[int, ...], tuple[Interval, Interval]]:
    """bias² and variance by the index of a setting.

    Empty where the sweep has no directory or one repeat; settings without all pictures are left
    out.
    """
    folder = folder_of(ds)
    if folder is None or ds.sizes.get("repeat", 1) < 2:
        return {}
    found = {}
    with Store(folder) as store:
        keys: dict[tuple[int, ...], list[tuple[str, str]]] = {}
        for point in store.definition()["points"]:
            keys.setdefault(tuple(point["index"][:-1]), []).append((point["key"], point["paired"]))
        finished = store.finished()
        for index, pairs in keys.items():
            if len(pairs) >= 2 and finished.issuperset(key for pair in pairs for key in pair):
                images = [
                    [store.frame(key).image for key in some] for some in zip(*pairs, strict=True)
                ]
                if float(np.sum(images[1])) > 0:
                    found[index] = bias_and_variance(images[0], images[1])
    return found


def _interval(values: Floats, level: float) -> Interval:
    mean, half = float(values.mean()) / level, half_width(values) / level
    return mean, mean - half, mean + half

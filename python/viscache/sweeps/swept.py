"""The settings of a sweep for plots and reports: means, colours, markers, Pareto front."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from viscache.metrics import confidence_interval

if TYPE_CHECKING:
    import xarray

#: Okabe and Ito's colours, told apart by colour-blind readers too.
COLORS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000", "#f0e442")
#: Number of different markers.
MOST_MARKERS = 8
#: If a parameter has more levels, they have no labels.
MOST_NAMED = 12


def settings_of(ds: xarray.Dataset, *variables: str) -> list[dict[str, Any]]:
    """Every setting with its means over repeats.

    Returns
    -------
    list of dict
        `{"index": (...), "values": {name: value}, variable: (mean, half of its 95 % interval)}`;
        settings without a finished repeat are left out; the half is 0 with one repeat.
    """
    dims = [str(d) for d in ds.dims if d not in ("repeat", "group")]
    names = [str(n) for n, c in ds.coords.items() if set(c.dims) <= set(dims) and c.dims]
    names = [n for n in names if n != "point"]
    result = []
    for index in np.ndindex(*(ds.sizes[d] for d in dims)):
        chosen = ds.isel(dict(zip(dims, index, strict=True)))
        setting: dict[str, Any] = {"index": index, "values": {n: chosen[n].item() for n in names}}
        for variable in variables:
            samples = [float(v) for v in chosen[variable].values.ravel() if np.isfinite(v)]
            if not samples:
                break
            low, high = confidence_interval(samples) if len(samples) > 1 else (0.0, 0.0)
            setting[variable] = (float(np.mean(samples)), (high - low) / 2)
        else:
            result.append(setting)
    return result


def levels_of(settings: Sequence[dict[str, Any]], names: Sequence[str]) -> list[list[Any]]:
    """The different values of parameters: numbers in order, others as they come."""
    found = [list(dict.fromkeys(s["values"][n] for s in settings)) for n in names]
    numbers = set(numbers_of(settings))
    return [sorted(v) if n in numbers else v for n, v in zip(names, found, strict=True)]


def error_of(ds: xarray.Dataset, wanted: str | None = None) -> str:
    """The metric that is wanted; the sweep's first by default.

    ValueError if the sweep has no such metric, or no value of it.
    """
    known = [str(name) for name in json.loads(ds.attrs["metrics"])]
    if wanted is None:
        if not known:
            raise ValueError("error must be a metric, and the sweep has none")
        return known[0]
    if wanted not in known:
        raise ValueError(f"error must be one of the sweep's metrics {known}, got {wanted!r}")
    if wanted not in ds or not bool(ds[wanted].notnull().any()):
        raise ValueError(f"error must be a metric that is defined, got {wanted!r}")
    return wanted


def is_grid(ds: xarray.Dataset) -> bool:
    """Whether two parameters or more were swept as a grid."""
    return sum(d not in ("repeat", "group", "point") for d in ds.dims) >= 2


def numbers_of(settings: Sequence[dict[str, Any]]) -> list[str]:
    """The swept parameters whose values are numbers that differ."""
    names = settings[0]["values"] if settings else {}
    columns = {n: [s["values"][n] for s in settings] for n in names}
    return [
        n
        for n, values in columns.items()
        if all(isinstance(v, (int, float)) and not isinstance(v, bool) for v in values)
        and len(set(values)) > 1
    ]


def pareto(points: list[tuple[float, float]]) -> list[tuple[float, float]]:
    """The Pareto front, sorted: points that no other point beats in both coordinates."""
    best: list[tuple[float, float]] = []
    for point in sorted(set(points)):
        if not best or point[1] < best[-1][1]:
            best.append(point)
    return best


def looks_of(levels: Sequence[Sequence[Any]]) -> Callable[[Sequence[Any]], tuple[str, int]]:
    """A function from the values of a setting to its colour and the number of its marker.

    The first parameter determines the colour, the second the marker; a single one determines both.
    With more than eight levels there is one marker.
    """
    colors = colors_for(len(levels[0]) if levels else 1)

    def look(values: Sequence[Any]) -> tuple[str, int]:
        at = [known.index(value) for known, value in zip(levels, values, strict=True)]
        by = min(1, len(at) - 1)
        marker = at[by] if at and len(levels[by]) <= MOST_MARKERS else 0
        return colors[at[0] if at else 0], marker

    return look


def first_of_levels(
    settings: Sequence[dict[str, Any]], names: Sequence[str], x: str
) -> list[dict[str, Any]]:
    """With two parameters, the most expensive setting of every level of the first parameter.

    Plots write the level beside it, so that colours are not the only difference.
    """
    if len(names) < 2:
        return []
    dearest: dict[Any, dict[str, Any]] = {}
    for setting in settings:
        level = setting["values"][names[0]]
        if level not in dearest or setting[x][0] > dearest[level][x][0]:
            dearest[level] = setting
    return list(dearest.values()) if len(dearest) <= MOST_NAMED else []


def colors_for(levels: int) -> tuple[str, ...]:
    """At least `levels` colours, all different: `COLORS`, or a scale if there are more levels."""
    if levels <= len(COLORS):
        return COLORS
    import matplotlib

    scale = matplotlib.colormaps["viridis"](np.linspace(0.1, 0.95, levels))
    return tuple(matplotlib.colors.to_hex(c) for c in scale)

"""The points of a sweep: ranges of one parameter, random and Latin-hypercube designs.

A range replaces a list of values: `{"log": [2, 32], "n": 9}` is nine values at equal ratios. A
design draws points from ranges and lists; its result is the argument `over` of `sweep`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from viscache.settings.checks import is_whole, require
from viscache.settings.spelling import nearest, spelled

__all__ = ["DESIGNS", "Range", "draw", "latin_hypercube", "random", "values_of"]

Floats = npt.NDArray[np.float64]


@spelled
@dataclass(frozen=True, slots=True)
class Range:
    """Numbers from `low` to `high`.

    Parameters
    ----------
    low, high : float
        low < high; both positive for `log`.
    spacing : {"linear", "log"}
        Equal steps or equal ratios.
    whole : bool
        Round to integers.
    """

    low: float
    high: float
    spacing: Literal["linear", "log"] = "linear"
    whole: bool = False

    def __post_init__(self) -> None:
        ends = (self.low, self.high)
        numbers = all(isinstance(v, (int, float)) and not isinstance(v, bool) for v in ends)
        require(numbers and all(map(math.isfinite, ends)), "a range must have two numbers", ends)
        require(self.low < self.high, "a range must have low < high", ends)
        require(
            self.spacing in ("linear", "log"), 'spacing must be "linear" or "log"', self.spacing
        )
        require(self.spacing == "linear" or self.low > 0, "a log range must have low > 0", ends)
        require(isinstance(self.whole, bool), "whole must be true or false", self.whole)

    def at(self, u: Floats) -> list[float | int]:
        """The values at positions u in [0, 1] along the range."""
        if self.spacing == "log":
            values = self.low * (self.high / self.low) ** u
        else:
            values = self.low + (self.high - self.low) * u
        values = np.clip(values, self.low, self.high)
        return [int(v) for v in np.rint(values)] if self.whole else [float(v) for v in values]

    def steps(self, n: int) -> list[float | int]:
        """n values including both ends; fewer if rounding makes some equal."""
        require(is_whole(n) and n >= 2, "n of a range must be a whole number >= 2", n)
        return list(dict.fromkeys(self.at(np.linspace(0.0, 1.0, int(n)))))


def values_of(name: str, value: Any) -> Any:
    """The list of values of a range `{"log": [2, 32], "n": 9}`; other values as they are."""
    if not isinstance(value, Mapping):
        return value
    found, n = _parse(name, value)
    if n is None:
        raise ValueError(f"over {name} must say how many values: n, got {dict(value)}")
    return found.steps(n)


@spelled
def random(over: Mapping[str, Any], n: int, *, seed: int = 0) -> list[dict[str, Any]]:
    """n points drawn independently.

    Parameters
    ----------
    over : mapping of name to Range, range table or list of values
        A list's values are equally likely.
    n : int >= 1
    seed : int >= 0
        Same seed, same points.

    Returns
    -------
    list of {name: value}

    Examples
    --------
    >>> points = random({"c_e": Range(2, 32, "log"), "c_n": [4, 8]}, 3)
    >>> [sorted(p) for p in points]
    [['c_e', 'c_n'], ['c_e', 'c_n'], ['c_e', 'c_n']]
    """
    return _points(over, n, seed, lambda rng, count: rng.random(count))


@spelled
def latin_hypercube(over: Mapping[str, Any], n: int, *, seed: int = 0) -> list[dict[str, Any]]:
    """n points, one in each of n equal slices of every parameter; arguments as of `random`."""
    return _points(
        over, n, seed, lambda rng, count: (rng.permutation(count) + rng.random(count)) / count
    )


#: What `[design] kind = …` of a sweep file may be.
DESIGNS: dict[str, Callable[..., list[dict[str, Any]]]] = {
    "random": random,
    "latin_hypercube": latin_hypercube,
}


def draw(design: Mapping[str, Any], over: Any) -> list[dict[str, Any]]:
    """Points of `{"kind": "latin_hypercube", "n": 50, "seed": 0}` over ranges and lists.

    Raises
    ------
    ValueError
        An unknown key or kind, with the nearest known one; a missing n.
    """
    known = ("kind", "n", "seed")
    for name in design:
        if name not in known:
            raise ValueError(f"design has no {name!r}{nearest(str(name), known)}")
    kind = design.get("kind")
    if kind not in DESIGNS:
        raise ValueError(f"unknown design {kind!r}{nearest(str(kind), DESIGNS)}")
    require("n" in design, "a design must say how many points: n", dict(design))
    require(isinstance(over, Mapping), "a design must be drawn over names and ranges", over)
    return DESIGNS[kind](over, design["n"], seed=design.get("seed", 0))


def _points(
    over: Mapping[str, Any],
    n: int,
    seed: int,
    positions: Callable[[np.random.Generator, int], Floats],
) -> list[dict[str, Any]]:
    require(bool(over), "over must name at least one parameter", dict(over))
    require(is_whole(n) and n >= 1, "n of a design must be a whole number >= 1", n)
    require(is_whole(seed) and 0 <= seed < 1 << 63, "seed must be in [0, 2^63)", seed)
    columns: dict[str, list[Any]] = {}
    for number, (name, what) in enumerate(over.items()):
        # Each parameter has its own stream, so adding a parameter does not change the others
        rng = np.random.Generator(np.random.Philox(key=[int(seed), number]))
        u = positions(rng, int(n))
        columns[name] = _picked(name, what, u)
    return [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)]


def _picked(name: str, what: Any, u: Floats) -> list[Any]:
    if isinstance(what, Mapping):
        found, n = _parse(name, what)
        require(n is None, f"over {name} must not have n in a design", dict(what))
        what = found
    if isinstance(what, Range):
        return what.at(u)
    listed = isinstance(what, Sequence) and not isinstance(what, str) and len(what) > 0
    require(listed, f"over {name} must be a range or a list of values", what)
    return [what[min(int(v * len(what)), len(what) - 1)] for v in u]


def _parse(name: str, table: Mapping[str, Any]) -> tuple[Range, int | None]:
    known = ("linear", "log", "n", "whole")
    for key in table:
        if key not in known:
            raise ValueError(f"the range of {name} has no {key!r}{nearest(str(key), known)}")
    if ("linear" in table) == ("log" in table):
        raise ValueError(f"the range of {name} must have linear or log, got {dict(table)}")
    spacing: Literal["linear", "log"] = "log" if "log" in table else "linear"
    ends = table[spacing]
    pair = isinstance(ends, Sequence) and not isinstance(ends, str) and len(ends) == 2
    require(pair, f"{spacing} of {name} must be [low, high]", ends)
    return Range(ends[0], ends[1], spacing, table.get("whole", False)), table.get("n")

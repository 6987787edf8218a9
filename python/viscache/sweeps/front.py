"""Which settings of a sweep are worth their cost, with intervals, and their bias and variance."""

from __future__ import annotations

import html
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from viscache.settings.checks import require
from viscache.sweeps.bias import of_sweep
from viscache.sweeps.swept import error_of, settings_of

if TYPE_CHECKING:
    import xarray


@dataclass(frozen=True, slots=True, kw_only=True)
class Ranked:
    """A setting of a sweep beside the others.

    Attributes
    ----------
    values : dict
        The swept parameters.
    cost, error : (mean, low, high)
        Over the repeats, with 95 % intervals. With one repeat all three are equal.
    dominated : bool
        Another setting has a smaller error at no more cost, or less cost at no more error.
    certain : bool
        Such a setting exists whose intervals of cost and error both lie below.
    bias2, variance : (mean, low, high), optional
        The two parts of the squared error of one frame, over the squared mean of the picture, with
        95 % intervals over blocks of it. None where pictures of repeats are missing.
    """

    values: dict[str, Any]
    cost: tuple[float, float, float]
    error: tuple[float, float, float]
    dominated: bool
    certain: bool
    bias2: tuple[float, float, float] | None = None
    variance: tuple[float, float, float] | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Front:
    """The settings of a sweep in the order of their cost; `vc.pareto`.

    Attributes
    ----------
    cost, error : str
        Names of the variables.
    settings : tuple of Ranked
    """

    cost: str
    error: str
    settings: tuple[Ranked, ...]

    @property
    def best(self) -> tuple[Ranked, ...]:
        """The settings that are not dominated: the Pareto front."""
        return tuple(s for s in self.settings if not s.dominated)

    def cheapest(self, error: float) -> Ranked | None:
        """The setting of least cost whose mean error is at most this; None if there is none."""
        return next((s for s in self.settings if s.error[0] <= error), None)

    def __iter__(self) -> Iterator[Ranked]:
        return iter(self.settings)

    def __len__(self) -> int:
        return len(self.settings)

    def _rows(self) -> list[list[str]]:
        names = list(self.settings[0].values) if self.settings else []
        split = any(s.bias2 is not None for s in self.settings)
        rows = [[*names, self.cost, self.error, *(["bias²", "variance"] if split else []), ""]]
        for s in self.settings:
            verdict = "" if not s.dominated else "dominated" if s.certain else "dominated?"
            values = [f"{v:g}" if isinstance(v, float) else str(v) for v in s.values.values()]
            parts = [_text(s.bias2), _text(s.variance)] if split else []
            rows.append([*values, _text(s.cost), _text(s.error), *parts, verdict])
        return rows

    def __str__(self) -> str:
        rows = self._rows()
        widths = [max(len(row[i]) for row in rows) for i in range(len(rows[0]))]
        lines = ["  ".join(c.ljust(w) for c, w in zip(row, widths, strict=True)) for row in rows]
        return "\n".join(line.rstrip() for line in lines)

    def _repr_html_(self) -> str:
        head, *rows = (
            "".join(f"<td>{html.escape(cell)}</td>" for cell in row) for row in self._rows()
        )
        body = "".join(
            f"<tr{' style=opacity:.5' if s.dominated else ''}>{row}</tr>"
            for s, row in zip(self.settings, rows, strict=True)
        )
        return f"<table><tr>{head.replace('td>', 'th>')}</tr>{body}</table>"


def pareto(
    ds: xarray.Dataset,
    cost: str = "total_s",
    error: str | None = None,
    *,
    split: bool | None = None,
) -> Front:
    """The settings of a sweep by cost, with those that another one beats marked.

    Repeats in a directory also tell bias and variance apart: bias² is the mean squared error of the
    mean over seeds, minus the variance of that mean (`viscache.sweeps.bias`).

    Parameters
    ----------
    ds : Dataset of `viscache.sweep`
    cost : str
        A variable to be small: "total_s", "cpu_s", "rays", ...
    error : str, optional
        A metric to be small; the sweep's first by default.
    split : bool, optional
        Read the pictures of all repeats to tell bias and variance apart. By default where the sweep
        has a directory and two repeats or more.

    Returns
    -------
    Front

    Raises
    ------
    ValueError
        There is no such variable, no finished setting, or `split` without the pictures it needs.

    Examples
    --------
    >>> import viscache as vc
    >>> cache = vc.Aqvc(exact_groups=())
    >>> ds = vc.sweep(
    ...     "slits", "direct", over={"c_e": [2, 16]}, visibility=cache, size=(48, 32)
    ... )
    >>> front = vc.pareto(ds, cost="rays")
    >>> [s.values["c_e"] for s in front], front.best[0].values["c_e"]
    ([16, 2], 16)
    """
    error = error_of(ds, error)
    require(cost in ds, "cost must be a variable of the sweep", cost)
    found = settings_of(ds, cost, error)
    require(bool(found), "ds must have a finished setting", ds.sizes)
    parts = {} if split is False else of_sweep(ds)
    require(not split or bool(parts), "split needs a sweep with a directory and repeats", ds.sizes)
    found.sort(key=lambda s: (s[cost][0], s[error][0]))
    return Front(
        cost=cost,
        error=error,
        settings=tuple(
            Ranked(
                values=s["values"],
                cost=_interval(s[cost]),
                error=_interval(s[error]),
                dominated=any(_beats(other, s, cost, error) for other in found),
                certain=any(_surely_beats(other, s, cost, error) for other in found),
                bias2=parts[s["index"]][0] if s["index"] in parts else None,
                variance=parts[s["index"]][1] if s["index"] in parts else None,
            )
            for s in found
        ),
    )


def _interval(found: tuple[float, float]) -> tuple[float, float, float]:
    mean, half = found
    return mean, mean - half, mean + half


def _beats(a: dict[str, Any], b: dict[str, Any], cost: str, error: str) -> bool:
    mine, other = (a[cost][0], a[error][0]), (b[cost][0], b[error][0])
    return mine != other and mine[0] <= other[0] and mine[1] <= other[1]


def _surely_beats(a: dict[str, Any], b: dict[str, Any], cost: str, error: str) -> bool:
    return all(sum(a[name]) < b[name][0] - b[name][1] for name in (cost, error))


def _text(interval: tuple[float, float, float] | None) -> str:
    if interval is None:
        return "–"
    mean, low, _ = interval
    return f"{mean:.4g}" if low == mean else f"{mean:.4g} ± {mean - low:.2g}"

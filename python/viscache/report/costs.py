"""What a sweep says in one sentence: the cost of an error, beside that of exact visibility.

For errors of 1, 2, 5 … per cent (or in units of the metric), the cheapest setting that has at most
this mean error is an *offer*. Its time and that of the exact frames come from the same sweep.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from viscache.plots import labels
from viscache.settings.checks import require
from viscache.sweeps.swept import error_of, pareto, settings_of

if TYPE_CHECKING:
    import xarray

#: Metrics that are shares, so that errors are told in per cent.
SHARES = ("rel_l1", "rel_l1_reflected")
#: Metrics of which less is not better.
NOT_ERRORS = ("ssim", "energy")
#: The error a verdict begins with, where settings reach it.
FIRST_TARGET = 0.01
MOST_OFFERS = 3

#: Mean and half of its 95 % interval, which is 0 with one repeat.
Interval = tuple[float, float]


@dataclass(frozen=True, slots=True, kw_only=True)
class Offer:
    """The cheapest setting of at most some error.

    Attributes
    ----------
    target : float
    index : tuple of int
        Place of the setting in the sweep.
    values : dict
        The swept parameters.
    error, seconds, exact_seconds, speedup : (mean, half of the 95 % interval)
    cpu_speedup : float, optional
        The same by CPU time, which other load on the machine disturbs less.
    """

    target: float
    index: tuple[int, ...]
    values: dict[str, Any]
    error: Interval
    seconds: Interval
    exact_seconds: Interval
    speedup: Interval
    cpu_speedup: float | None = None

    @property
    def is_disturbed(self) -> bool:
        """Whether wall and CPU time disagree by a quarter: something else ran meanwhile."""
        other = self.cpu_speedup
        return other is not None and max(other, self.speedup[0]) > 1.25 * min(
            other, self.speedup[0]
        )

    @property
    def pays(self) -> bool | None:
        """Whether it is faster than exact visibility; None where the interval holds both."""
        mean, half = self.speedup
        return None if mean - half <= 1 <= mean + half else mean > 1


@dataclass(frozen=True, slots=True, kw_only=True)
class Verdict:
    """The offers of a sweep, and what stands where there is none.

    Attributes
    ----------
    metric : str
    target : float
        The error that was asked for, or 1 %.
    offers : tuple of Offer
        By their targets; each is another setting.
    least : Offer
        The setting of least error.
    alone : bool
        No frame of the sweep ran beside another, so times are undisturbed.
    """

    metric: str
    target: float
    offers: tuple[Offer, ...]
    least: Offer
    alone: bool

    def sentences(self, setting: Callable[[Offer], str] | None = None) -> list[str]:
        """The first offer, then the others; `setting` writes the parameters of one."""
        named = setting or _setting
        told = []
        if not self.offers or self.offers[0].target > self.target:
            told.append(
                f"No setting has {_error(self.metric, self.target)}: the smallest is"
                f" {_value(self.metric, self.least.error[0])}, at {named(self.least)}."
            )
        costs = [self._cost(offer, named, first=i == 0) for i, offer in enumerate(self.offers)]
        if costs:
            told.append(f"{costs[0]}.")
        if costs[1:]:
            told.append(f"{'; '.join(costs[1:])}.")
        if self.offers and self.offers[0].is_disturbed:
            told.append(
                f"Other load disturbed these times: by CPU time it is"
                f" {self.offers[0].cpu_speedup:.2g}×."
            )
        elif not self.alone:
            told.append("Frames ran beside each other, so times are rough.")
        return told

    def _cost(self, offer: Offer, named: Callable[[Offer], str], first: bool) -> str:
        error, at = _error(self.metric, offer.target), named(offer)
        exact = f"{_seconds(offer.exact_seconds)} s"
        mean, half = offer.speedup
        if offer.pays is False:
            return (
                f"{error}: exact visibility is faster, {exact} against"
                f" {_seconds(offer.seconds)} s, at {at}"
            )
        factor = f"{mean:.2g} ± {half:.1g}×" if half else f"{mean:.2g}×"
        instead = f" instead of {exact}" if first else ""
        sure = "" if offer.pays else ", no surely measured gain"
        return f"{error} costs {_seconds(offer.seconds)} s{instead} ({factor}{sure}), at {at}"

    def __str__(self) -> str:
        return " ".join(self.sentences())


def verdict(
    ds: xarray.Dataset, error: str | None = None, target: float | None = None
) -> Verdict | None:
    """What a sweep's settings cost; None if its metric is not an error, or times are missing.

    Parameters
    ----------
    ds : Dataset of `viscache.sweep`
    error : str, optional
        The sweep's first metric by default.
    target : float, optional
        The error that is wanted; by default the verdict begins with 1 % where settings reach it.

    Raises
    ------
    ValueError
        `target` is not above 0.
    """
    require(target is None or target > 0, "target must be > 0", target)
    metric = error_of(ds, error)
    columns = (metric, "total_s", "exact_total_s", "speedup")
    if metric in NOT_ERRORS or not all(c in ds for c in columns):
        return None
    found = sorted(settings_of(ds, *columns), key=lambda s: (s["total_s"][0], s[metric][0]))
    if not found:
        return None
    wanted = FIRST_TARGET if target is None else target
    least = min(found, key=lambda s: (s[metric][0], s["total_s"][0]))
    return Verdict(
        metric=metric,
        target=wanted,
        offers=_offers(ds, found, metric, wanted, exactly=target is not None),
        least=_offer(ds, least, metric, least[metric][0]),
        alone="alone" not in ds or bool((ds["alone"].fillna(1) > 0).all()),
    )


def knee(points: Sequence[tuple[float, float]]) -> int:
    """The number of the point (cost, error) where a Pareto front bends most.

    That is the one farthest below the line between the front's ends, both axes logarithmic. Of two
    points or less it is the one of least error.
    """
    front = [p for p in pareto(list(points)) if p[0] > 0 and p[1] > 0]
    if len(front) < 3:
        return min(range(len(points)), key=lambda i: (points[i][1], points[i][0]))
    logs = [(math.log(x), math.log(y)) for x, y in front]
    (x0, y0), (x1, y1) = logs[0], logs[-1]
    below = [(y0 - y) * (x1 - x0) + (y1 - y0) * (x - x0) for x, y in logs]
    return list(points).index(front[max(range(len(front)), key=below.__getitem__)])


def _offers(
    ds: xarray.Dataset, found: list[dict[str, Any]], metric: str, wanted: float, *, exactly: bool
) -> tuple[Offer, ...]:
    """The offer for the wanted error, or the nearest there is, and those for larger ones."""
    errors = [s[metric][0] for s in found]
    ladder = _ladder(max(min(errors), 1e-12), max(*errors, 1e-12))
    targets = sorted({*ladder, wanted}) if exactly else ladder
    offers: list[Offer] = []
    for target in targets:
        setting = next((s for s in found if s[metric][0] <= target), None)
        if setting is not None and (not offers or setting["index"] != offers[-1].index):
            offers.append(_offer(ds, setting, metric, target))
    before = [i for i, offer in enumerate(offers) if offer.target <= wanted * (1 + 1e-9)]
    first = before[-1] if before else 0
    return tuple(offers[first : first + MOST_OFFERS])


def _ladder(low: float, high: float) -> list[float]:
    """1, 2 and 5 times powers of ten, from just above `low` to just above `high`."""
    decades = range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)
    steps = [float(f"{s}e{d}") for d in decades for s in (1, 2, 5)]
    last = next(i for i, step in enumerate(steps) if step >= high)
    return [step for step in steps[: last + 1] if step >= low]


def _offer(ds: xarray.Dataset, setting: dict[str, Any], metric: str, target: float) -> Offer:
    cpu = None
    if "cpu_speedup" in ds:
        dims = [d for d in ds.dims if d not in ("repeat", "group")]
        here = ds["cpu_speedup"].isel(dict(zip(dims, setting["index"], strict=True)))
        cpu = float(here.mean()) if bool(here.notnull().any()) else None
    return Offer(
        target=target,
        index=tuple(setting["index"]),
        values=setting["values"],
        error=setting[metric],
        seconds=setting["total_s"],
        exact_seconds=setting["exact_total_s"],
        speedup=setting["speedup"],
        cpu_speedup=cpu,
    )


def _setting(offer: Offer) -> str:
    return labels.setting(offer.values)


def _value(metric: str, value: float) -> str:
    return f"{100 * value:.3g} %" if metric in SHARES else f"{value:.3g}"


def _error(metric: str, target: float) -> str:
    if metric in SHARES:
        return f"{_value(metric, target)} error"
    return f"{labels.plain(metric, unit=False)} {_value(metric, target)}"


def _seconds(found: Interval) -> str:
    mean, half = found
    return f"{mean:.2g} ± {half:.1g}" if half else f"{mean:.2g}"

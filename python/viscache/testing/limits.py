"""Limits of metrics: which values of a metric meet a limit, and by how much others miss it."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

from viscache.metrics import METRICS, Metrics, check_names
from viscache.settings.checks import require

#: What a limit of a metric bounds; of all others, the value from above.
SENSES: dict[str, Literal["size", "least"]] = {"energy": "size", "ssim": "least"}


@dataclass(frozen=True, slots=True)
class Limit:
    """A limit of one metric: its value, or its interval over repeats, must lie within."""

    metric: str
    bound: float

    @property
    def range(self) -> tuple[float, float]:
        """What values may be."""
        sense = SENSES.get(self.metric)
        if sense == "least":
            return (self.bound, math.inf)
        return (-self.bound if sense == "size" else -math.inf, self.bound)

    def ends(self, measured: Metrics) -> tuple[float, float] | None:
        """The interval of the mean over repeats, or the value twice; None if undefined."""
        value = measured[self.metric]
        return None if value is None else measured.intervals.get(self.metric, (value, value))

    def holds(self, measured: Metrics) -> bool:
        """Whether all of the interval is within the limit; False if the metric is undefined."""
        ends = self.ends(measured)
        low, high = self.range
        return ends is not None and low <= ends[0] and ends[1] <= high

    def __str__(self) -> str:
        if SENSES.get(self.metric) == "size":
            return f"within ±{self.bound:g}"
        return f"{'>=' if SENSES.get(self.metric) == 'least' else '<='} {self.bound:g}"

    def told(self, measured: Metrics) -> str:
        """The value, the limit, and whether it is met."""
        value, ends = measured[self.metric], self.ends(measured)
        if value is None or ends is None:
            return f"undefined     must be {self}"
        text = f"{value:<11.4g}"
        if ends != (value, value):
            text += f" (95 %: {ends[0]:.4g} to {ends[1]:.4g})"
        if self.holds(measured):
            return f"{text}   is {self}"
        times = max(abs(end) for end in ends) / self.bound if self.bound else math.inf
        more = f", {times:.3g} times" if times > 1 and math.isfinite(times) else ""
        return f"{text}   must be {self}{more}"


def checked(given: Mapping[str, float | None]) -> list[Limit]:
    """The limits that are given, in the order of the metrics.

    ValueError if there is none, a metric is unknown, or nothing or everything meets a bound.
    """
    limits = [Limit(name, bound) for name, bound in given.items() if bound is not None]
    check_names([limit.metric for limit in limits])
    require(bool(limits), "there must be a limit of at least one metric", "none")
    for limit in limits:
        bound = limit.bound
        number = isinstance(bound, (int, float)) and not isinstance(bound, bool)
        most = 1.0 if limit.metric in ("ssim", "flip") else math.inf
        fits = number and 0 <= bound <= most and math.isfinite(bound)
        require(fits, f"{limit.metric} must be a limit >= 0{' and <= 1' * (most == 1)}", bound)
    return sorted(limits, key=lambda limit: list(METRICS).index(limit.metric))


def parsed(text: str) -> Limit:
    """The limit of "rel_l1<=0.02", "energy<=0.01" (both ways), "ssim>=0.98", or ValueError."""
    found = re.fullmatch(r"\s*(\w+)\s*(<=|>=)\s*(\S+)\s*", text)
    require(found is not None, 'a limit must be like "rel_l1<=0.02" or "ssim>=0.98"', text)
    assert found is not None
    name, sign, number = found.groups()
    check_names([name])
    wanted = ">=" if SENSES.get(name) == "least" else "<="
    require(sign == wanted, f"a limit of {name} must be {name}{wanted}NUMBER", text)
    try:
        bound = float(number)
    except ValueError:
        bound = math.nan
    return checked({name: bound})[0]

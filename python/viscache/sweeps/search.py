"""The search for the value of a parameter that has a wanted error.

The error of one picture follows no simple law of the parameter. So a few pilots are rendered, and
the pilots next to the target are joined by a straight line in logarithms. The next pilot stands
where that line crosses the target.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from viscache.sweeps.tuned import TOLERANCE, Pilot

#: A pilot this near to the target is near enough.
NEAR = 0.04
MOST_PILOTS = 8
#: A step away from all pilots: a factor, or this share of a range that begins at zero or below.
FACTOR, SHARE = 2.5, 1 / 6
#: Values that differ by less count as the same.
SAME = 1e-3
#: Between values that differ by less nothing is searched: a factor, or this share of a range that
#: begins at zero or below.
CLOSE = 0.03


@dataclass(frozen=True, slots=True, kw_only=True)
class Span:
    """Where to search: from `low` to `high`, by equal ratios if `low` is positive, else by lengths.

    `whole` takes whole numbers only. The `first` two pilots are a third and two thirds along the
    range by default. `rises` says whether the error rises with the value; pilots tell it by
    default.
    """

    low: float
    high: float
    whole: bool = False
    first: tuple[float, float] | None = None
    rises: bool | None = None

    @property
    def beginning(self) -> tuple[float, float]:
        """The first two pilots."""
        if self.first is not None:
            return self.first
        one, two = (self._rounded(self.along(self.low, self.high, k / 3)) for k in (1, 2))
        return one, max(two, one + 1) if self.whole else two

    def along(self, a: float, b: float, share: float) -> float:
        """The value at a share of the way from a to b."""
        return a * (b / a) ** share if self.low > 0 else a + (b - a) * share

    def beyond(self, value: float, *, up: bool) -> float:
        """The next value outside of the pilots."""
        if self.low > 0:
            moved = FACTOR * value if up else value / FACTOR
        else:
            moved = value + (SHARE if up else -SHARE) * (self.high - self.low)
        if self.whole:
            moved = max(value + 1, round(moved)) if up else min(value - 1, round(moved))
        end = self.high if up else self.low
        past = moved > end if up else moved < end
        return end if past or self.same(moved, end) else moved

    def inside(self, a: float, b: float, share: float) -> float | None:
        """The value at a share of the way, none that a or b has already."""
        value = self._rounded(self.along(a, b, share))
        if not self.whole:
            return value
        low, high = min(a, b) + 1, max(a, b) - 1
        return min(high, max(low, value)) if low <= high else None

    def same(self, a: float, b: float, tolerance: float = SAME) -> bool:
        """Whether two values are too near to each other for two pilots."""
        if self.whole:
            return a == b
        if self.low > 0:
            return abs(a / b - 1) < tolerance
        return abs(a - b) < tolerance * (self.high - self.low)

    def _rounded(self, value: float) -> float:
        return round(value) if self.whole else value


def search(
    measure: Callable[[float], Pilot],
    target: float,
    span: Span,
    *,
    known: Sequence[Pilot] = (),
    most: int = MOST_PILOTS,
) -> list[Pilot]:
    """Pilots towards the value whose error is the target, in the order of the search.

    `known` are earlier ones to begin with; `most` counts them, too.
    """
    tried = list(known) or [measure(value) for value in span.beginning]
    while len(tried) < most:
        if any(abs(p.error / target - 1) <= NEAR for p in tried):
            break
        value = _next_value(tried, target, span)
        if value is None or any(span.same(value, p.value) for p in tried):
            break
        tried.append(measure(value))
    return tried


def best(pilots: Sequence[Pilot], target: float, *, whole: bool = False) -> Pilot:
    """The pilot whose error is nearest to the target.

    Whole numbers may all be far from it. Then one that reaches the target is preferred.
    """
    reached = [p for p in pilots if p.error <= target * TOLERANCE] if whole else []
    return min(reached or pilots, key=lambda p: abs(math.log(max(p.error, 1e-12) / target)))


def _next_value(tried: Sequence[Pilot], target: float, span: Span) -> float | None:
    rises = _rises(tried) if span.rises is None else span.rises
    if rises is None:  # all pilots have the same error
        known = {p.value for p in tried}
        return next((end for end in (span.high, span.low) if end not in known), None)
    # From the end of small errors to the end of large ones
    ordered = sorted(tried, key=lambda p: p.value, reverse=not rises)
    numbers = range(len(ordered))
    below = [i for i in numbers if ordered[i].error <= target]
    if len(below) == len(ordered):
        return span.beyond(ordered[-1].value, up=rises)
    if not below:
        return span.beyond(ordered[0].value, up=not rises)
    if below[-1] + 1 == len(ordered):
        return None
    return _crossing(ordered[below[-1]], ordered[below[-1] + 1], target, span)


def _rises(tried: Sequence[Pilot]) -> bool | None:
    """Whether the error rises with the value; None if it seems to stay the same."""
    first = min(tried, key=lambda p: p.value).error
    last = max(tried, key=lambda p: p.value).error
    return None if first == last else last > first


def _crossing(low: Pilot, high: Pilot, target: float, span: Span) -> float | None:
    """Where the line through two pilots, in logarithms, has the target; None if they are close."""
    if span.same(low.value, high.value, CLOSE):
        return None
    a, b = (math.log(max(p.error, target * 1e-3)) for p in (low, high))
    share = min(0.95, max(0.05, (math.log(target) - a) / (b - a)))
    return span.inside(low.value, high.value, share)

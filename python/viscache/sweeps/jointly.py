"""C_E together with C_L, `c_finest` and `bright` of the quantized cache.

Smaller finest cells and traced bright connections cost rays, and allow a larger C_E at the same
error. After the search over C_E alone, one pilot of each family of these two tells what it would
cost at the target, by the slopes of the pilots so far. The best family is searched, too.
C_L, the size of light cells, is chosen before.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import TypeAlias

import numpy as np

from viscache.settings.not_given import NotGiven, plain
from viscache.settings.visibility import Aqvc
from viscache.sweeps.search import Span, best, search
from viscache.sweeps.tuned import OWN_SAMPLES, Pilot

Also: TypeAlias = Mapping[str, float]

#: Pilots of the family that is searched.
EACH = 4
MOST_MORE = 5 + EACH - 1
#: `bright` of the families; smaller values trace more.
BRIGHT = 4.0
#: Pilots whose error is off by more do not stand for the target.
NEARLY = 1.2
#: A family is searched if its first pilot promises to be cheaper by this share.
LEAST_GAIN = 0.05
#: Slopes of logarithms: of the goal over C_E, and of the price over the goal. Few pilots of one
#: picture may give wild ones.
STEEP, WORTH = (0.2, 2.0), (0.3, 1.0)
#: C_L is halved at most so often, and this many sizes are tried.
MOST_HALVINGS, MOST_TRIALS = 6, 3
#: At a C_E this small, only light cells cause errors.
FINE_C_E = 1.0


def with_light_cells(groups: Callable[[Aqvc], dict[str, float]], base: Aqvc, target: float) -> Aqvc:
    """The settings with a C_L that leaves C_E at least half of the target.

    Light cells matter for samples that belong to one pixel each. If `base` has a C_L, it stays. The
    error of light cells is about proportional to their size, so each trial tells how many halvings
    are missing. `groups` takes settings and gives the error of each light group.
    """
    halvings = 0
    for _ in range(MOST_TRIALS if isinstance(base.c_l, NotGiven) else 0):
        errors = groups(replace(_halved(base, halvings), c_e=FINE_C_E))
        over = sum(e for name, e in errors.items() if name in OWN_SAMPLES) / (target / 2)
        if over <= 1 or halvings == MOST_HALVINGS:
            break
        halvings = min(MOST_HALVINGS, halvings + math.ceil(math.log2(over)))
    return _halved(base, halvings)


def _halved(base: Aqvc, halvings: int) -> Aqvc:
    return replace(base, c_l=0.5**halvings) if halvings else base


def families(base: Aqvc, *, beside: Also | None = None, c_e: float = 0.0) -> list[dict[str, float]]:
    """Other values of `c_finest` and `bright`; those that were given stay.

    `beside` the best of the first families are those next to it. `c_e` is that of the best one, or
    that found without them.
    """
    finest, bright = float(plain(base.c_finest)), float(plain(base.bright))
    free = isinstance(base.c_finest, NotGiven), isinstance(base.bright, NotGiven)
    traced = BRIGHT if free[1] else bright
    if beside is None:
        wanted = [(finest, traced)]
        wanted += [(finest / 2, bright), (finest / 2, traced)] if free[0] else []
        wanted += [(2 * finest, bright)] if free[0] and c_e > 4 * finest else []
    elif beside["c_finest"] < finest:
        wanted = [(finest / 4, beside["bright"])]
    else:
        wanted = [(2 * finest, beside["bright"])] if free[0] and c_e > 2 * finest else []
    of_base = (finest, bright)
    return [{"c_finest": f, "bright": b} for f, b in dict.fromkeys(wanted) if (f, b) != of_base]


def jointly(
    measure: Callable[[float, Also], Pilot],
    tried: Sequence[Pilot],
    target: float,
    span: Span,
    others: Callable[..., Sequence[Also]],
    price: Callable[[Pilot], float],
    finest: float = 4.0,
) -> tuple[list[Pilot], Pilot]:
    """All pilots, `tried` included, which varied C_E alone; and the one to use.

    `measure` takes C_E and the other values, and gives a pilot whose error should be `target`.
    `others` takes `c_e` and gives the families to try; with `beside`, those beside the best of
    them. The price should be small at the target. `finest` is the `c_finest` of the pilots tried.
    """
    one = best(tried, target)
    off = math.log(max(one.error, 1e-12) / target)
    easy = off < 0 and span.same(one.value, span.high)  # coarser families may reach the target
    if abs(off) > math.log(NEARLY) and not easy:
        return list(tried), one
    sign = -1.0 if span.rises is False else 1.0
    steep = _slope([(p.value, p.error) for p in tried], sign, STEEP)
    worth = _slope([(p.error, price(p)) for p in tried], -1.0, WORTH)

    def at_target(pilot: Pilot) -> float:
        """The logarithm of the price at the target."""
        off = math.log(target / max(pilot.error, 1e-12))
        return math.log(max(price(pilot), 1e-12)) + worth * off

    def probed(also: Also) -> Pilot:
        """A pilot at about the target: C_E grows as cells shrink."""
        grown = (1.2 if also["bright"] else 1.0) * (finest / also["c_finest"]) ** 0.7
        value = max(span.low, one.value * grown, 2 * also["c_finest"])
        return measure(min(span.high, value), also)

    probes = [probed(also) for also in others(c_e=one.value)]
    if probes:
        first = min(probes, key=at_target)
        if at_target(first) < at_target(one) - LEAST_GAIN:
            probes += [probed(also) for also in others(beside=first.also, c_e=first.value)]
    found = [[one]]
    probe = min(probes, key=at_target, default=one)
    if at_target(probe) < at_target(one) - LEAST_GAIN:
        moved = probe.value * (target / max(probe.error, 1e-12)) ** (1 / steep)
        moved = min(span.high, max(span.low, min(4 * probe.value, max(probe.value / 4, moved))))

        def here(value: float) -> Pilot:
            return measure(value, probe.also)

        known = [probe] if span.same(moved, probe.value, 0.05) else [probe, here(moved)]
        found.append(search(here, target, span, known=known, most=EACH))
    chosen = [best(pilots, target) for pilots in found]
    near = [p for p in chosen if abs(math.log(max(p.error, 1e-12) / target)) <= math.log(NEARLY)]
    searched = [p for pilots in found for p in pilots if p is not one]
    rest = [p for p in probes if not any(p is q for q in searched)]
    return [*tried, *rest, *searched], min(near or [one], key=at_target)


def _slope(points: Sequence[tuple[float, float]], sign: float, ends: tuple[float, float]) -> float:
    """Slope of logarithms by least squares, of a known sign and within bounds."""
    x, y = np.log(np.maximum(np.array(points, float), 1e-12)).T
    spread = float(np.square(x - x.mean()).sum())
    found = float(((x - x.mean()) * (y - y.mean())).sum()) / spread if spread > 1e-9 else 0.0
    return sign * min(ends[1], max(ends[0], sign * found))

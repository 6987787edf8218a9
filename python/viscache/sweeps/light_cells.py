"""The size of light cells, C_L, for a wanted error of the quantized cache."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

from viscache.settings.not_given import NotGiven
from viscache.settings.visibility import Aqvc
from viscache.sweeps.tuned import OWN_SAMPLES

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

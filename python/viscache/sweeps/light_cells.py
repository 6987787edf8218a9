"""The size of light cells, C_L, for a wanted error of the quantized cache."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from viscache.settings.not_given import NotGiven
from viscache.settings.visibility import Aqvc
from viscache.sweeps.tuned import OWN_SAMPLES

__all__ = ["with_light_cells"]

#: C_L is halved at most so often.
MOST_HALVINGS = 6
#: At a C_E this small, only light cells cause errors.
FINE_C_E = 1.0


def with_light_cells(groups: Callable[[Aqvc], dict[str, float]], base: Aqvc, target: float) -> Aqvc:
    """The settings with a C_L that leaves C_E at least half of the target.

    Light cells matter for samples that belong to one pixel each. If `base` has a C_L, it stays.

    Parameters
    ----------
    groups : callable
        Takes settings, returns the error of each light group.
    base : Aqvc
    target : float
        The wanted error.
    """
    tried = base
    for halvings in range(MOST_HALVINGS + 1 if isinstance(base.c_l, NotGiven) else 0):
        tried = replace(base, c_l=0.5**halvings) if halvings else base
        errors = groups(replace(tried, c_e=FINE_C_E))
        if sum(error for name, error in errors.items() if name in OWN_SAMPLES) <= target / 2:
            break
    return tried

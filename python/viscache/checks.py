"""Checks of arguments: what must hold, what was given."""

from __future__ import annotations

from typing import Any


def require(holds: bool, what: str, given: Any) -> None:
    """Raise ValueError("<what>, got <given>") unless the condition holds.

    Comparisons with NaN are false, so ranges refuse it.
    """
    if not holds:
        raise ValueError(f"{what}, got {given!r}")

"""Names that nobody knows are refused with the nearest known one."""

from __future__ import annotations

import difflib
from collections.abc import Iterable

__all__ = ["nearest"]


def nearest(name: str, known: Iterable[str]) -> str:
    """'; did you mean "x"?' or '; known: ...': the end of a message about an unknown name."""
    names = list(known)
    close = difflib.get_close_matches(name, names, 1, cutoff=0.5)
    if close:
        return f"; did you mean {close[0]!r}?"
    return f"; known: {', '.join(names)}" if names else "; there are none"

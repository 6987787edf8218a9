"""A case to measure, and the check that it becomes: a value against a limit."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeAlias

#: The most that a value may be, or the interval that it must lie in.
Limit: TypeAlias = float | tuple[float, float]


@dataclass(frozen=True, kw_only=True, slots=True)
class Case:
    """What to measure, and the limit that was set beforehand."""

    name: str
    measure: Callable[[], float]
    limit: Limit = 0
    why: str
    """Where the limit comes from: a derivation, or a measured value and the margin."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Check:
    """The result of a case."""

    name: str
    value: float | None
    """None where nothing was measured: `error` says why, and the check fails."""
    limit: Limit
    why: str = ""
    error: str = ""
    family: str = ""
    isa: str = ""
    cpu_s: float = 0.0
    """CPU seconds of its process."""

    @property
    def holds(self) -> bool:
        """Whether the value is within the limit; NaN never is."""
        return self.value is not None and holds(self.value, self.limit)

    def as_dict(self) -> dict[str, Any]:
        """The check for JSON."""
        limit = list(self.limit) if isinstance(self.limit, tuple) else self.limit
        told = {"name": self.name, "value": self.value, "limit": limit, "holds": self.holds}
        more = {
            "family": self.family,
            "isa": self.isa,
            "why": self.why,
            "error": self.error,
            "cpu_s": round(self.cpu_s, 3),
        }
        return told | {name: value for name, value in more.items() if value}

    @classmethod
    def from_dict(cls, told: dict[str, Any]) -> Check:
        """The check of `as_dict`."""
        limit = told["limit"]
        fields = {n: v for n, v in told.items() if n not in ("holds", "limit")}
        return cls(limit=tuple(limit) if isinstance(limit, list) else limit, **fields)

    def line(self) -> str:
        """One line of text."""
        state = "ok  " if self.holds else "FAIL"
        if self.value is None:
            return f"{state} {self.name} ({self.error})"
        ends = self.limit if isinstance(self.limit, tuple) else (self.limit,)
        words = " … ".join(f"{end:.4g}" for end in ends)
        return f"{state} {self.name} ({self.value:.4g}, limit {words})"


def holds(value: float, limit: Limit) -> bool:
    """Whether a value is within a limit."""
    low, high = limit if isinstance(limit, tuple) else (-math.inf, limit)
    return low <= value <= high


def checked(case: Case) -> Check:
    """The case, measured now. Whatever it raises fails the check."""
    try:
        value = float(case.measure())
    except Exception as error:
        told = f"{type(error).__name__}: {error}"
        return Check(name=case.name, value=None, limit=case.limit, why=case.why, error=told)
    if math.isnan(value):
        return Check(
            name=case.name, value=None, limit=case.limit, why=case.why, error="not a number"
        )
    return Check(name=case.name, value=value, limit=case.limit, why=case.why)

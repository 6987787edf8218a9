"""A case to measure, and the check that it becomes: a value against a limit."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from typing import Any, TypeAlias

#: The most that a value may be, or the interval that it must lie in.
Limit: TypeAlias = float | tuple[float, float]


@dataclass(frozen=True, kw_only=True, slots=True)
class Case:
    """What to measure, and the limit that was set beforehand."""

    name: str
    measure: Callable[[], float]
    limit: Limit = 0
    why: str  # where the limit comes from: a derivation, or a measured value and the margin


@dataclass(frozen=True, kw_only=True, slots=True)
class Check:
    """The result of a case."""

    name: str
    value: float | None  # none where nothing was measured: `error` says why, and the check fails
    limit: Limit
    why: str = ""
    error: str = ""
    family: str = ""
    isa: str = ""
    cpu_s: float = 0.0  # CPU seconds of its process

    @property
    def holds(self) -> bool:
        """Whether the value is within the limit; NaN never is."""
        low, high = self.limit if isinstance(self.limit, tuple) else (-math.inf, self.limit)
        return self.value is not None and low <= self.value <= high

    def as_dict(self) -> dict[str, Any]:
        """The check for JSON; what is empty is left out."""
        told = asdict(self) | {"holds": self.holds, "cpu_s": round(self.cpu_s, 3)}
        if isinstance(self.limit, tuple):
            told["limit"] = list(self.limit)
        must = ("name", "value", "limit", "holds")
        return {name: value for name, value in told.items() if name in must or value}

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


def unmeasured(case: Case) -> Check:
    """The check of a case before there is a value."""
    return Check(name=case.name, value=None, limit=case.limit, why=case.why)


def checked(case: Case) -> Check:
    """The case, measured now. Whatever it raises fails the check."""
    check = unmeasured(case)
    try:
        value = float(case.measure())
    except Exception as error:
        return replace(check, error=f"{type(error).__name__}: {error}")
    if math.isnan(value):
        return replace(check, error="not a number")
    return replace(check, value=value)

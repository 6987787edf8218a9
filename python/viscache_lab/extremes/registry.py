"""The list of families of checks."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TypeAlias

from viscache.settings.checks import require
from viscache_lab.extremes.case import Case

__all__ = ["FAMILIES", "Family", "family"]

#: Called with `full`; gives the cases one by one.
Cases: TypeAlias = Callable[[bool], Iterator[Case]]


@dataclass(frozen=True, kw_only=True, slots=True)
class Family:
    """Checks of one subject, which share a process."""

    description: str
    cases: Cases
    every_isa: bool = True
    """Whether `--full` repeats it for every instruction set."""
    most_bytes: int | None = None
    """Address space of its process."""


#: Name to family, in alphabetical order of their files.
FAMILIES: dict[str, Family] = {}


def family(
    name: str, description: str, *, every_isa: bool = True, most_bytes: int | None = None
) -> Callable[[Cases], Cases]:
    """Register a generator of cases; see `Family`."""
    require(name not in FAMILIES, "a family's name must be its own", name)

    def register(cases: Cases) -> Cases:
        FAMILIES[name] = Family(
            description=description, cases=cases, every_isa=every_isa, most_bytes=most_bytes
        )
        return cases

    return register

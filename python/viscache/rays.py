"""Which rays hit, and where: settings of the exact ray casters."""

from __future__ import annotations

from dataclasses import dataclass

from viscache.checks import check_types

__all__ = ["Embree"]


@dataclass(frozen=True, kw_only=True, slots=True)
class Embree:
    """Rays by Embree.

    Parameters
    ----------
    robust : bool
        Watertight edges and the same answer from every instruction set; costs 15–35 % speed.
    """

    robust: bool = True

    def __post_init__(self) -> None:
        check_types(self)

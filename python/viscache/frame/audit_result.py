"""What the audit of a frame tells: estimates of its error, with intervals."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True, slots=True)
class Estimate:
    """An estimate with its 95 % interval.

    Attributes
    ----------
    value : float
    se : float
        Standard error.
    low, high : float or None
        None where no interval was shown to hold: from too few pixels or too few errors.
    why : str or None
        Why there is no interval.
    """

    value: float
    se: float
    low: float | None = None
    high: float | None = None
    why: str | None = None

    def __str__(self) -> str:
        if self.low is None or self.high is None:
            return f"{self.value:.4g}"
        return f"{self.value:.4g} [{self.low:.4g}, {self.high:.4g}]"


@dataclass(frozen=True, kw_only=True, slots=True)
class PixelErrors:
    """Estimates from whole pixels. A light group's errors are relative to its own light.

    Attributes
    ----------
    pixels, rays : int
        Audited pixels, and exact rays for them.
    rel_l1, rel_l1_reflected, nrmse : Estimate or None
        Σ|a - b| / Σb, the same without emitted light that the camera sees, and sqrt(mean (a - b)²)
        / mean b, of the frame a and the exact frame b. None without light.
    groups : dict of str to PixelErrors
        The same of single light groups, each by its layer. `rel_l1_reflected` is None.
    """

    pixels: int
    rays: int
    rel_l1: Estimate | None
    rel_l1_reflected: Estimate | None
    nrmse: Estimate | None
    groups: dict[str, PixelErrors]


@dataclass(frozen=True, kw_only=True, slots=True)
class QueryErrors:
    """Estimates from single queries. A light group's bias is relative to its own light.

    Attributes
    ----------
    queries, audited, rays : int
        Queries of the frame, those audited, and exact rays for them.
    bias : Estimate or None
        Σ(a - b) / Σb of the frame a and the exact frame b. None without light.
    wrong : Estimate or None
        Share of wrong answers. None without queries.
    groups : dict of str to QueryErrors
        The same of single light groups.
    """

    queries: int
    audited: int
    rays: int
    bias: Estimate | None
    wrong: Estimate | None
    groups: dict[str, QueryErrors]


def result(record: Mapping[str, Any] | None) -> PixelErrors | QueryErrors | None:
    """The result from its record in the counters of a frame."""
    if record is None:
        return None
    of_groups = record.get("groups", {})
    groups = {name: result({"kind": record["kind"], **r}) for name, r in of_groups.items()}
    kind: Any = PixelErrors if record["kind"] == "pixels" else QueryErrors
    rest = {
        name: Estimate(**value) if isinstance(value, Mapping) else value
        for name, value in record.items()
        if name not in ("kind", "groups")
    }
    if kind is PixelErrors:
        rest.setdefault("rel_l1_reflected", None)
    made: PixelErrors | QueryErrors = kind(**rest, groups=groups)
    return made


def audit_rows(record: Mapping[str, Any] | None) -> dict[str, str]:
    """Names and estimates for tables; nothing without an interval."""
    if record is None:
        return {}
    rows: dict[str, str] = {}
    for group, values in {"": record, **record["groups"]}.items():
        for name, value in values.items():
            if isinstance(value, Mapping) and value.get("low") is not None:
                rows[f"{name} {group}".strip()] = str(Estimate(**value))
    return rows

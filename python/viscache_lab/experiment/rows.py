"""Measured values beside what a paper prints and a band."""

from __future__ import annotations

import csv
import math
from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from viscache_lab.experiment.claim_rules import Claim


@dataclass(frozen=True, slots=True)
class Band:
    """The interval of a measured value, both ends included, and its source."""

    low: float
    high: float
    source: str  # the paper's sentence, or the expectation, behind the band
    _: KW_ONLY
    claimed: Claim | None = None
    """Where the paper's claim is found; None if the source quotes no paper."""

    @property
    def claim(self) -> tuple[float, float] | None:
        """Both ends of the interval where the paper's claim is found, if it states one."""
        return None if self.claimed is None else (self.claimed.low, self.claimed.high)

    @property
    def said(self) -> str:
        """What the paper prints, with its place, without our expectation."""
        return self.source.partition("; ")[0]

    def __contains__(self, value: object) -> bool:
        return isinstance(value, (int, float)) and self.low <= value <= self.high


def read_bands(path: Path) -> SimpleNamespace:
    """The bands of a CSV file, by their names; those with keys as a dict."""
    found: dict[str, Any] = {}
    with path.open(encoding="utf-8", newline="") as file:
        for row in csv.DictReader(file):
            rule, *numbers = row["claim"].split() or [""]
            claimed = Claim.by(rule, *map(float, numbers), because=row["because"]) if rule else None
            band = Band(float(row["low"]), float(row["high"]), row["source"], claimed=claimed)
            if row["key"]:
                key = int(row["key"]) if row["key"].isdigit() else row["key"]
                found.setdefault(row["name"], {})[key] = band
            else:
                found[row["name"]] = band
    return SimpleNamespace(**found)


@dataclass(frozen=True, slots=True)
class Row:
    """One row of a figure's table."""

    what: str
    measured: float | None  # none if it could not be measured; then the band does not hold
    _: KW_ONLY
    printed: float | str | None = None  # the paper's value; None without one
    band: Band | None = None
    note: str = ""

    @property
    def ratio(self) -> float | None:
        """Measured over printed, if both are numbers."""
        if isinstance(self.printed, str) or not self.printed or self.measured is None:
            return None
        return self.measured / self.printed

    @property
    def holds(self) -> bool | None:
        """Whether the band holds; None without a band."""
        return None if self.band is None else self.measured in self.band

    @property
    def found(self) -> bool | None:
        """Whether the paper's claim is found; None if it states none."""
        claim = None if self.band is None else self.band.claim
        if claim is None:
            return None
        return self.measured is not None and claim[0] <= self.measured <= claim[1]

    def as_dict(self) -> dict[str, Any]:
        """The row for JSON; an open end of the band or claim is null."""
        band = None if self.band is None else [self.band.low, self.band.high]
        claim = None if self.band is None or not self.band.claim else list(self.band.claim)
        claimed = None if self.band is None else self.band.claimed
        source = [] if self.band is None else [self.band.source]
        return {
            "what": self.what,
            "printed": self.printed,
            "measured": self.measured,
            "ratio": self.ratio,
            "band": band,
            "holds": self.holds,
            "claim": claim,
            "rule": None if claimed is None else claimed.rule,
            "because": None if claimed is None else claimed.because,
            "said": None if self.band is None or claimed is None else self.band.said,
            "found": self.found,
            "note": "; ".join(text for text in (self.note, *source) if text),
        }


def text(figure: str, rows: Sequence[Row]) -> str:
    """Rows as a Markdown table."""
    lines = [
        f"# {figure}",
        "",
        "| what | printed | measured | ratio | band | holds | note |",
        "| --- | --- | --- | --- | --- | --- | --- |",
    ]
    for row in rows:
        band = "" if row.band is None else f"{_number(row.band.low)} … {_number(row.band.high)}"
        holds = {None: "", True: "yes", False: "**no**"}[row.holds]
        cells = [row.what, _number(row.printed), _number(row.measured), _number(row.ratio)]
        lines.append(f"| {' | '.join([*cells, band, holds, row.as_dict()['note']])} |")
    return "\n".join(lines) + "\n"


def _number(value: float | str | None) -> str:
    if value is None or isinstance(value, str):
        return value or ""
    return "∞" if value == math.inf else f"{value:.4g}"

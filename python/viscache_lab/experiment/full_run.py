"""The last full run of each figure, as `full_run.json` keeps it.

`scripts/claims_pages.py DIR` writes that file from the folder of `viscache reproduce all`, and the
tables of the documentation from the file.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from viscache.base.files import finite

#: Of a row that judges a claim.
KEPT = ("what", "measured", "said", "rule", "because")
FILE = Path(__file__).with_name("full_run.json")


@dataclass(frozen=True, slots=True)
class Judged:
    """A row that judges a claim of a paper."""

    what: str
    measured: float | None
    said: str  # what the paper prints, with its place
    rule: str
    because: str  # the reason of a limit for words
    low: float
    high: float

    @property
    def found(self) -> bool:
        """Whether the paper's claim is found."""
        return self.measured is not None and self.low <= self.measured <= self.high

    @property
    def claim(self) -> tuple[str, str, str, float, float]:
        """What is judged; rows of the same claim have the same."""
        return self.said, self.rule, self.because, self.low, self.high


@dataclass(frozen=True, slots=True)
class Failing:
    """A row whose band does not hold."""

    what: str
    measured: float | None
    low: float
    high: float


@dataclass(frozen=True, slots=True)
class FullRun:
    """A full run of one figure."""

    date: str  # year, month and day
    machine: str  # its name in docs/performance/method.md
    seconds: float
    cpu_s: float
    bands: int  # rows that have a band
    failing: tuple[Failing, ...]
    judged: tuple[Judged, ...]


def kept(result: Mapping[str, Any], machine: str) -> FullRun:
    """What is kept of a result; ValueError if it was quick, had another size, or an error."""
    if result["quick"] or result["size"] is not None or "error" in result:
        raise ValueError(
            f"runs must be full, in their own size and without an error; {result['figure']} is not"
        )
    rows = result["rows"]
    return FullRun(
        date=result["provenance"]["date"][:10],
        machine=machine,
        seconds=round(result["seconds"], 1),
        cpu_s=round(result["cpu_s"], 1),
        bands=sum(row["holds"] is not None for row in rows),
        failing=tuple(
            Failing(row["what"], row["measured"], *_ends(row["band"]))
            for row in rows
            if row["holds"] is False
        ),
        judged=tuple(
            Judged(*[*map(row.get, KEPT), *_ends(row["claim"])])
            for row in rows
            if row["claim"] is not None
        ),
    )


def _ends(interval: tuple[float | None, float | None]) -> tuple[float, float]:
    """Both ends; an open one is null in JSON."""
    low, high = interval
    return -math.inf if low is None else low, math.inf if high is None else high


def written(runs: Mapping[str, FullRun]) -> str:
    """The text of the file."""
    return json.dumps(finite({name: asdict(run) for name, run in runs.items()}), indent=1) + "\n"


def read(text: str) -> dict[str, FullRun]:
    """Figure to its last full run, from the text of the file."""

    def opened(row: dict[str, Any]) -> dict[str, Any]:
        low, high = _ends((row["low"], row["high"]))
        return {**row, "low": low, "high": high}

    runs: dict[str, dict[str, Any]] = json.loads(text)
    for run in runs.values():
        for key, kind in (("failing", Failing), ("judged", Judged)):
            run[key] = tuple(kind(**opened(row)) for row in run[key])
    return {name: FullRun(**run) for name, run in runs.items()}


RUNS: dict[str, FullRun] = read(FILE.read_text("utf-8"))
#: Figures that judge a claim of a paper, if only in full runs.
CLAIMING = frozenset(name for name, run in RUNS.items() if run.judged)

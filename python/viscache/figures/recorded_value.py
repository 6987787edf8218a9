"""A value of a full run that judges a claim of a paper, and the run that gave it."""

from __future__ import annotations

import math
from dataclasses import dataclass

from viscache.figures.outcome import Band, Row

__all__ = ["Missing", "Recorded", "Run", "interval", "words"]


@dataclass(frozen=True, kw_only=True, slots=True)
class Run:
    """A full run of `viscache reproduce FIGURE`."""

    figure: str
    date: str
    """Year, month and day."""
    machine: str
    """Its name in docs/performance/method.md."""
    frame: str
    """What was rendered or traced."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Recorded:
    """A value of a full run."""

    figure: str
    what: str
    """The row of the figure, or what a page calls it."""
    band: Band
    written: str
    """The value as a page writes it, with " %" for percent."""
    page: str = ""
    """Page of the documentation that holds the value; without one it is docs/claims.md alone."""
    section: str = ""
    """Heading on the page."""

    @property
    def measured(self) -> float:
        """The value as a number."""
        number, percent, _ = self.written.partition(" %")
        return float(number) / (100 if percent else 1)

    @property
    def found(self) -> bool | None:
        """Whether the paper's claim is found."""
        return Row(self.what, self.measured, band=self.band).found

    @property
    def said(self) -> str:
        """What the paper prints, with its place."""
        return words(self.band)

    @property
    def link(self) -> str:
        """The value in Markdown, with a link to its page if it has one."""
        if not self.page:
            return self.written
        anchor = self.section.lower().replace(":", "").replace(" ", "-")
        return f"[{self.written}]({self.page}#{anchor})"


@dataclass(frozen=True, kw_only=True, slots=True)
class Missing:
    """A claim that a figure judges in full runs, without a recorded run."""

    figure: str
    band: Band
    reason: str


def words(band: Band) -> str:
    """What the paper prints, with its place, without our expectation."""
    return band.source.partition("; ")[0]


def interval(low: float, high: float) -> str:
    """The interval in words."""
    if low == high:
        return f"{low:g}"
    if high == math.inf:
        return f"≥ {low:.3g}"
    return f"≤ {high:.3g}" if low == 0 else f"{low:.5g} to {high:.5g}"

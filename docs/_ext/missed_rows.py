"""Rows of missed goals in the pages of docs/performance."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass


@dataclass(frozen=True)
class Missed:
    section: str
    what: str
    words: str


def missed(source: str) -> Iterator[Missed]:
    """Table rows that name a missed goal: their first cell and the cells with the word."""
    section, head = "", []
    for line in source.splitlines():
        if line.startswith("## "):
            section = line[3:]
        cells = [cell.strip() for cell in line.strip("|").split("|")] if line[:1] == "|" else []
        if not cells:
            head = []
        elif not head:
            head = cells
        elif any("missed" in cell for cell in cells):
            named = zip(head, cells, strict=True)
            said = [f"{name}: {cell}".lstrip(": ") for name, cell in named if "missed" in cell]
            yield Missed(section, cells[0], "; ".join(said))


def anchor(section: str) -> str:
    """The heading's anchor in links, as MyST and GitHub make it."""
    return re.sub(r"[^\w\- ]", "", section.lower()).replace(" ", "-")

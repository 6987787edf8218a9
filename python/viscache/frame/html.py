"""A frame in notebooks: its picture, six numbers, and the rest folded."""

from __future__ import annotations

import base64
import html
from collections.abc import Mapping
from typing import Any

from viscache.base import tonemap
from viscache.frame.audit_result import audit_rows

#: The numbers that are shown first, as many as a frame has.
FIRST = ("total_s", "cpu_s", "visibility_s", "queries", "rays", "ray_reduction")


def frame_html(image: Any, timings: Mapping[str, float], counters: Mapping[str, Any]) -> str:
    """A picture no wider than 640 pixels and two tables."""
    numbers = {name: (value, f" ({clock(name)})") for name, value in timings.items()}
    numbers |= {name: (value, "") for name, value in counters.items()}
    rows = {name: row for name, row in numbers.items() if _is_number(row[0])}
    errors = audit_rows(counters.get("audit"))
    first = [name for name in FIRST if name in rows]
    first += [name for name in rows if name not in first][: len(FIRST) - len(first)]
    rest = [name for name in rows if name not in first]
    shown = _table(rows, first) + _errors(errors)
    if rest:
        shown += f"<details><summary>{len(rest)} more</summary>{_table(rows, rest)}</details>"
    height, width = image.shape[:2]
    return f"<div>{picture(image, f'{width}x{height} frame')}{shown}</div>"


def picture(image: Any, words: str) -> str:
    """A scene-linear image as an HTML element."""
    png = tonemap.encode(tonemap.to_srgb8(image), max_width=640)
    data = base64.b64encode(png).decode("ascii")
    return f"<img alt='{html.escape(words)}' src='data:image/png;base64,{data}'>"


def clock(name: str) -> str:
    """The clock of a timing: CPU seconds of all threads, or wall seconds."""
    return "CPU" if name == "cpu_s" or name.endswith("_cpu_s") else "wall"


def _table(rows: Mapping[str, tuple[Any, str]], names: list[str]) -> str:
    cells = "".join(
        f"<tr><td>{html.escape(name)}{rows[name][1]}</td>"
        f"<td style='text-align:right'>{_number(rows[name][0])}</td></tr>"
        for name in names
    )
    return f"<table>{cells}</table>"


def _errors(rows: Mapping[str, str]) -> str:
    if not rows:
        return ""
    cells = "".join(
        f"<tr><td>{html.escape(name)}</td>"
        f"<td style='text-align:right'>{html.escape(text)}</td></tr>"
        for name, text in rows.items()
    )
    return f"<table><caption>audit, with 95 % intervals</caption>{cells}</table>"


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def _number(value: float) -> str:
    return f"{value:,}" if isinstance(value, int) else f"{value:.4g}"

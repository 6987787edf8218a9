"""Heat maps of two parameters and pair plots of many, as inline SVG."""

from __future__ import annotations

import html
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from viscache.plots import labels
from viscache.plots.labels import number
from viscache.report.pictures import scale_colors
from viscache.report.svg import Area, Axis, across, frame, upwards

CELL_W, CELL_H = 64, 40
PANEL, GAP = 150, 26


@dataclass(frozen=True, kw_only=True, slots=True)
class Dot:
    """A setting in pair plots: its parameter values as numbers, and its result."""

    id: str
    at: Mapping[str, float]
    value: float


def shade(values: Sequence[float]) -> Callable[[float], tuple[str, float]]:
    """Maps a value to a colour of cividis and its position on the scale; logarithmic like axes."""
    axis, colors = Axis(values, 0.0, 1.0), scale_colors("cividis")
    finite = [v for v in values if math.isfinite(v)]
    low, high = (axis(min(finite)), axis(max(finite))) if finite else (0.0, 1.0)

    def look(value: float) -> tuple[str, float]:
        share = (axis(value) - low) / (high - low) if high > low else 0.5
        share = min(1.0, max(0.0, share))
        r, g, b = (int(c) for c in colors[round(255 * share)])
        return f"#{r:02x}{g:02x}{b:02x}", share

    return look


def heatmap(
    plot_id: str,
    names: tuple[str, str],
    levels: tuple[Sequence[str], Sequence[str]],
    cells: Mapping[tuple[int, int], tuple[float, str | None]],
    value: str,
) -> str:
    """Heat map of a variable over two parameters; a click on a cell selects its setting.

    `cells` has (value, id of the setting or None for a mean over several) by (column, row).
    """
    columns, rows = len(levels[0]), len(levels[1])
    area = Area(left=72, top=34, right=72 + columns * CELL_W, bottom=34 + rows * CELL_H)
    width, height = area.right + 16, area.bottom + 48
    look = shade([v for v, _ in cells.values()])
    chosen = all(which for _, which in cells.values())
    whole = f' data-rows="{rows}"' if len(cells) == rows * columns else ""
    roles = f'role="radiogroup"{whole}' if chosen else 'role="group"'
    parts = [
        f'<svg id="{plot_id}" class="plot" viewBox="0 0 {width} {height}" {roles} '
        f'style="min-width:{0.8 * width:.0f}px;max-width:{1.35 * width:.0f}px" '
        f'aria-label="{html.escape(labels.plain(value))} '
        f"over {html.escape(labels.plain(names[0]))} and "
        f'{html.escape(labels.plain(names[1]))}">',
        f'<text class="label" x="{area.left}" y="20">{labels.as_svg(value)}</text>',
        across(area, height - 8, names[0]),
        upwards(area, 14, names[1]),
    ]
    for i, text in enumerate(levels[0]):
        parts.append(
            f'<text class="tick" x="{area.left + (i + 0.5) * CELL_W}" text-anchor="middle"'
            f' y="{area.bottom + 16}">{html.escape(text)}</text>'
        )
    for j, text in enumerate(levels[1]):
        y = area.bottom - (j + 0.5) * CELL_H
        parts.append(
            f'<text class="tick" x="{area.left - 8}" y="{y}" dy=".35em" text-anchor="end">'
            f"{html.escape(text)}</text>"
        )
    for (i, j), (cell, setting) in sorted(cells.items()):
        color, share = look(cell)
        x, y = area.left + i * CELL_W, area.bottom - (j + 1) * CELL_H
        which = f' data-id="{setting}"' if setting else ""
        which += ' role="radio"' if chosen else ""
        ink = "#fff" if share < 0.5 else "#000"
        parts.append(
            f'<g class="cell"{which}><rect x="{x}" y="{y}" width="{CELL_W}" height="{CELL_H}" '
            f'fill="{color}"/><text x="{x + CELL_W / 2}" y="{y + CELL_H / 2}" dy=".35em" '
            f'text-anchor="middle" fill="{ink}">{number(float(f"{cell:.3g}"))}</text></g>'
        )
    if chosen:
        parts.append(f'<rect class="around" width="{CELL_W}" height="{CELL_H}"/>')
    return "".join(parts) + "</svg>"


def pairs(plot_id: str, names: Sequence[str], dots: Sequence[Dot], value: str) -> str:
    """A variable over every pair of parameters: lighter and larger dots are larger values.

    The diagonal shows the variable over one parameter.
    """
    look = shade([d.value for d in dots])
    order = np.argsort(np.argsort([d.value for d in dots]))
    sizes = 2.5 + 3.5 * order / max(1, len(dots) - 1)
    side = PANEL + GAP
    width, height = 84 + len(names) * side, 20 + len(names) * side + 40
    parts = [
        f'<svg id="{plot_id}" class="plot" viewBox="0 0 {width} {height}" role="img" '
        f'style="min-width:{0.7 * width:.0f}px;max-width:{1.15 * width:.0f}px" '
        f'aria-label="{html.escape(labels.plain(value))} '
        f'over pairs of {html.escape(", ".join(labels.plain(n) for n in names))}">',
        _color_bar(look, [d.value for d in dots], value, width),
    ]
    for row, down in enumerate(names):
        for column, along in enumerate(names[: row + 1]):
            left, top = 84 + column * side, 16 + row * side
            area = Area(left=left, top=top, right=left + PANEL, bottom=top + PANEL)
            on_diagonal = row == column
            x = Axis([d.at[along] for d in dots], area.left, area.right)
            y = Axis([d.value if on_diagonal else d.at[down] for d in dots], area.bottom, area.top)
            last = row == len(names) - 1
            parts.append(
                frame(x, y, area, x_ticks=last, y_ticks=(column == 0 and row > 0) or row == 0)
            )
            if last:
                parts.append(across(area, area.bottom + 36, along))
            if column == 0:
                parts.append(upwards(area, 22, value if row == 0 else down))
            for dot, size in zip(dots, sizes, strict=True):
                cx, cy = x(dot.at[along]), y(dot.value if on_diagonal else dot.at[down])
                parts.append(
                    f'<circle class="dot" data-id="{dot.id}" cx="{cx:.1f}" cy="{cy:.1f}" '
                    f'r="{size:.1f}" fill="{look(dot.value)[0]}"/>'
                )
    return "".join(parts) + "</svg>"


def _color_bar(
    look: Callable[[float], tuple[str, float]], values: Sequence[float], value: str, width: float
) -> str:
    left, right, top = width - 250, width - 30, 34
    axis = Axis(values, left, right)
    parts = [f'<text class="label" x="{left}" y="{top - 10}">{labels.as_svg(value)}</text>']
    for i in range(64):
        share = (i + 0.5) / 64
        low, high = math.log(axis.low) if axis.log else axis.low, axis.high
        at = low + share * ((math.log(high) if axis.log else high) - low)
        color, _ = look(math.exp(at) if axis.log else at)
        parts.append(
            f'<rect x="{left + 220 * i / 64:.1f}" y="{top}" width="3.9" height="12" '
            f'fill="{color}"/>'
        )
    for tick in axis.ticks():
        parts.append(
            f'<text class="tick" x="{axis(tick):.1f}" y="{top + 27}" '
            f'text-anchor="middle">{number(tick)}</text>'
        )
    return "".join(parts)

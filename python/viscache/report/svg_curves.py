"""Curves as inline SVG: a line per setting, a point per step."""

from __future__ import annotations

import html
import math
from collections.abc import Sequence
from dataclasses import dataclass

from viscache.plots.labels import number, plain
from viscache.report.svg import (
    BOTTOM,
    HEIGHT,
    LEFT,
    RIGHT,
    TOP,
    WIDTH,
    Area,
    Axis,
    across,
    frame,
    upwards,
)

#: Points are smaller than those of settings.
SCALE = 0.55


@dataclass(frozen=True, kw_only=True, slots=True)
class Curve:
    """The points of one setting."""

    id: str
    x: Sequence[float]
    y: Sequence[float]
    color: str
    shape: str  #: outline around (0, 0)
    text: str


def curves(plot_id: str, drawn: Sequence[Curve], x_name: str, y_name: str) -> str:
    """A plot of curves; points that are not positive are left out."""
    area = Area(left=LEFT, top=TOP, right=WIDTH - RIGHT, bottom=HEIGHT - BOTTOM)
    shown = [
        (c, [(i, a, b) for i, (a, b) in enumerate(zip(c.x, c.y, strict=True), 1) if _fits(a, b)])
        for c in drawn
    ]
    x = Axis([a for _, points in shown for _, a, _ in points], area.left, area.right)
    y = Axis([b for _, points in shown for _, _, b in points], area.bottom, area.top)
    parts = [
        f'<svg id="{plot_id}" class="plot" viewBox="0 0 {WIDTH} {HEIGHT}" role="img" '
        f'aria-label="{html.escape(plain(y_name))} over {html.escape(plain(x_name))}">',
        frame(x, y, area),
        across(area, HEIGHT - 10, x_name),
        upwards(area, 16, y_name),
    ]
    for curve, points in shown:
        line = "L".join(f"{x(a):.1f} {y(b):.1f}" for _, a, b in points)
        if line:
            parts.append(f'<path d="M{line}" fill="none" stroke="{curve.color}"/>')
        for i, a, b in points:
            words = f"{curve.text}, pass {i}: {plain(y_name)} {b:.4g}, {plain(x_name)} {number(a)}"
            parts.append(
                f'<path class="point" data-id="{curve.id}" d="{curve.shape}" fill="{curve.color}" '
                f'transform="translate({x(a):.1f} {y(b):.1f}) scale({SCALE})">'
                f"<title>{html.escape(words)}</title></path>"
            )
    return "".join(parts) + "</svg>"


def _fits(x: float, y: float) -> bool:
    return math.isfinite(x) and math.isfinite(y) and x > 0 and y > 0

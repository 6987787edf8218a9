"""Plots as inline SVG. Scatter plots have one `<path class="point" data-id=… d=…>` per setting."""

from __future__ import annotations

import html
import math
from collections.abc import Sequence
from dataclasses import dataclass

from viscache.plots import labels
from viscache.plots.labels import number
from viscache.sweeps.swept import pareto

WIDTH, HEIGHT = 440, 320
LEFT, RIGHT, TOP, BOTTOM = 66, 12, 16, 46

#: Outlines around (0, 0) of equal visual weight: circle, square, triangles, diamond, cross …
SHAPES = (
    "M6 0A6 6 0 1 1-6 0A6 6 0 1 1 6 0Z",
    "M-5.3-5.3H5.3V5.3H-5.3Z",
    "M0-7.2L6.6 5H-6.6Z",
    "M0-7.5L7.5 0L0 7.5L-7.5 0Z",
    "M0 7.2L6.6-5H-6.6Z",
    "M-2.3-6.8H2.3V-2.3H6.8V2.3H2.3V6.8H-2.3V2.3H-6.8V-2.3H-2.3Z",
    "M-7.2 0L-3.6-6.2H3.6L7.2 0L3.6 6.2H-3.6Z",
    "M0-8L2.1-2.6L7.6-2.5L3.3 1.1L4.7 6.5L0 3.4L-4.7 6.5L-3.3 1.1L-7.6-2.5L-2.1-2.6Z",
)


@dataclass(frozen=True, kw_only=True, slots=True)
class Mark:
    """One setting in a plot: mean and half width of its 95 % interval on both axes."""

    id: str
    x: float
    y: float
    half_x: float
    half_y: float
    color: str
    shape: str  #: outline around (0, 0)
    text: str
    beside: str = ""  #: written next to it


class Axis:
    """Maps values to pixels; logarithmic if all values are positive and span more than 3×."""

    def __init__(self, values: Sequence[float], begin: float, end: float) -> None:
        finite = [v for v in values if math.isfinite(v)] or [0.0, 1.0]
        low, high = min(finite), max(finite)
        self.log = low > 0 and high > 3 * low
        if self.log:
            self.low, self.high = low / 1.25, high * 1.25
        else:
            pad = 0.08 * (high - low) or abs(high) * 0.1 or 1.0
            self.low, self.high = low - pad, high + pad
            if low >= 0 > self.low:
                self.low = 0.0
        self.begin, self.end = begin, end

    def __call__(self, value: float) -> float:
        f = math.log if self.log else float
        floor = max(value, self.low) if self.log else value
        share = (f(floor) - f(self.low)) / (f(self.high) - f(self.low))
        return self.begin + share * (self.end - self.begin)

    def ticks(self) -> list[float]:
        """Numbers of the form 1, 2, 5 times a power of ten inside the axis."""
        if self.log:
            decades = range(math.floor(math.log10(self.low)), math.ceil(math.log10(self.high)) + 1)
            span = math.log10(self.high / self.low)
            steps = (1, 1.5, 2, 3, 4, 5, 6, 8) if span < 0.8 else (1, 2, 5) if span < 2.2 else (1,)
            candidates = [s * 10.0**d for d in decades for s in steps]
        else:
            rough = (self.high - self.low) / 5
            power = 10.0 ** math.floor(math.log10(rough))
            step = next(s * power for s in (1, 2, 5, 10) if s * power >= rough)
            first = math.ceil(self.low / step)
            candidates = [(first + i) * step for i in range(12)]
        return [t for t in candidates if self.low <= t <= self.high]


@dataclass(frozen=True, kw_only=True, slots=True)
class Area:
    """The rectangle of a plot inside its picture, in pixels."""

    left: float
    top: float
    right: float
    bottom: float


def frame(x: Axis, y: Axis, area: Area, *, x_ticks: bool = True, y_ticks: bool = True) -> str:
    """Grid lines, their labels and the two axes."""
    parts = []
    for tick in x.ticks():
        at = f"{x(tick):.1f}"
        parts.append(f'<line class="grid" x1="{at}" x2="{at}" y1="{area.top}" y2="{area.bottom}"/>')
        if x_ticks:
            parts.append(
                f'<text class="tick" x="{at}" y="{area.bottom + 16}" text-anchor="middle">'
                f"{number(tick)}</text>"
            )
    for tick in y.ticks():
        at = f"{y(tick):.1f}"
        parts.append(f'<line class="grid" x1="{area.left}" x2="{area.right}" y1="{at}" y2="{at}"/>')
        if y_ticks:
            parts.append(
                f'<text class="tick" x="{area.left - 8}" y="{at}" dy=".35em" '
                f'text-anchor="end">{number(tick)}</text>'
            )
    parts.append(f'<path class="axis" d="M{area.left} {area.top}V{area.bottom}H{area.right}"/>')
    return "".join(parts)


def across(area: Area, y: float, name: str) -> str:
    """A variable's label below an area."""
    return (
        f'<text class="label" x="{(area.left + area.right) / 2}" y="{y}" text-anchor="middle">'
        f"{labels.as_svg(name)}</text>"
    )


def upwards(area: Area, x: float, name: str) -> str:
    """A variable's label beside an area, rotated."""
    return (
        f'<text class="label" transform="translate({x} {(area.top + area.bottom) / 2}) '
        f'rotate(-90)" text-anchor="middle">{labels.as_svg(name)}</text>'
    )


def scatter(
    plot_id: str, marks: Sequence[Mark], x_name: str, y_name: str, exact: float | None = None
) -> str:
    """The plot of two variables, with the Pareto front.

    `exact` draws a dashed line at the exact frame's mean cost.
    """
    costs = [m.x for m in marks] + ([exact] if exact is not None and math.isfinite(exact) else [])
    area = Area(left=LEFT, top=TOP, right=WIDTH - RIGHT, bottom=HEIGHT - BOTTOM)
    x = Axis(costs, area.left, area.right)
    y = Axis([m.y for m in marks], area.bottom, area.top)
    parts = [
        f'<svg id="{plot_id}" class="plot" viewBox="0 0 {WIDTH} {HEIGHT}" '
        f'role="radiogroup" aria-label="{html.escape(labels.plain(y_name))} against '
        f'{html.escape(labels.plain(x_name))}">',
        frame(x, y, area),
        across(area, HEIGHT - 8, x_name),
        upwards(area, 14, y_name),
    ]
    if exact is not None and math.isfinite(exact):
        line = x(exact)
        parts.append(
            f'<line class="exact" x1="{line:.1f}" x2="{line:.1f}" y1="{TOP}" y2="{area.bottom}"/>'
        )
        parts.append(
            f'<text class="tick" x="{line - 5:.1f}" y="{TOP + 10}" text-anchor="end">exact</text>'
        )
    front = pareto([(m.x, m.y) for m in marks])
    points = " ".join(f"{x(px):.1f},{y(py):.1f}" for px, py in front)
    parts.append(f'<polyline class="front" points="{points}"/>')
    parts.append(
        f'<clipPath id="{plot_id}-area"><rect x="{LEFT}" y="{TOP}" '
        f'width="{area.right - LEFT}" height="{area.bottom - TOP}"/></clipPath>'
    )
    parts += [_bars(m, x, y, f"url(#{plot_id}-area)") for m in marks]
    for m in sorted(marks, key=lambda m: (m.x, m.y)):  # in the order of the arrow keys
        at = f"{x(m.x):.1f} {y(m.y):.1f}"
        parts.append(
            f'<path class="point" data-id="{m.id}" d="{m.shape}" transform="translate({at})" '
            f'fill="{m.color}" role="radio" aria-label="{html.escape(m.text)}">'
            f"<title>{html.escape(m.text)}</title></path>"
        )
        if m.beside:
            parts.append(
                f'<text class="tick" x="{x(m.x) + 9:.1f}" y="{y(m.y) - 6:.1f}">'
                f"{html.escape(m.beside)}</text>"
            )
    return "".join(parts) + "</svg>"


def _bars(m: Mark, x: Axis, y: Axis, area: str) -> str:
    """The 95 % intervals of a mark."""
    bars = []
    if m.half_x:
        bars.append(f"M{x(m.x - m.half_x):.1f} {y(m.y):.1f}H{x(m.x + m.half_x):.1f}")
    if m.half_y:
        bars.append(f"M{x(m.x):.1f} {y(m.y - m.half_y):.1f}V{y(m.y + m.half_y):.1f}")
    path = "".join(bars)
    return f'<path class="bar" clip-path="{area}" stroke="{m.color}" d="{path}"/>' if bars else ""

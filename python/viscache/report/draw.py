"""The plots of a page: trade-off, heat maps and pair plots, depending on the swept parameters."""

from __future__ import annotations

import html
import math
from typing import TYPE_CHECKING, Any

from viscache.plots import labels
from viscache.plots.labels import number, plain
from viscache.report.svg import SHAPES, Mark, scatter
from viscache.report.svg_grids import Dot, heatmap, pairs
from viscache.sweeps.swept import (
    MOST_MARKERS,
    MOST_NAMED,
    first_of_levels,
    is_grid,
    levels_of,
    looks_of,
    numbers_of,
)

if TYPE_CHECKING:
    import xarray

#: Heat maps with more cells, and pair plots with more dots, are omitted; see `viscache.plots`.
MOST_CELLS, MOST_DOTS = 240, 12_000


def plots(model: dict[str, Any], ds: xarray.Dataset) -> str:
    """All plots, each with its legend."""
    costs = [c for c in ("total_s", "rays") if c in model["columns"]]
    looks, key = _looks(model)
    parts = [_group([_trade(model, ds, cost, looks) for cost in costs]), key]
    error = model["metrics"][0]
    if is_grid(ds):
        shown = [m for v in (error, *costs[-1:]) if (m := _heatmap(model, ds, v))]
        rest = len(model["names"]) - 2
        more = f" Means over {rest} more parameter{'s' * (rest > 1)}." if rest else ""
        if shown:
            parts.append(
                f"<h2>Over two parameters</h2>{_group(shown)}"
                f'<p class="quiet">Darker cells have smaller values.{more}</p>'
            )
    names = numbers_of(model["settings"])
    dots = len(model["settings"]) * len(names) * (len(names) + 1) // 2
    if len(names) >= (2 if "point" in ds.dims else 3) and dots <= MOST_DOTS:
        drawn = pairs(f"pairs-{error}", names, _dots(model, names, error), error)
        parts.append(
            f"<h2>Over every two parameters</h2><figure>{drawn}</figure>"
            '<p class="quiet">Lighter and larger dots are greater. On the diagonal stands '
            "the value itself, on the scale of the first panel.</p>"
        )
    return "".join(parts)


def _group(figures: list[str]) -> str:
    return f'<div class="plots">{"".join(f"<figure>{f}</figure>" for f in figures)}</div>'


def _trade(
    model: dict[str, Any], ds: xarray.Dataset, cost: str, looks: dict[str, tuple[str, str]]
) -> str:
    metric = model["metrics"][0]
    shown = [s for s in model["settings"] if s["cells"][cost]]
    flat = [{**s, cost: s["cells"][cost]} for s in shown]
    named = {s["id"] for s in first_of_levels(flat, model["names"], cost)}
    marks = []
    for s in shown:
        (px, hx), (py, hy) = s["cells"][cost], s["cells"][metric]
        if math.isfinite(px):
            color, shape = looks[s["id"]]
            text = f"{s['text']}: {plain(metric)} {py:.4g}, {plain(cost)} {number(px)}"
            beside = labels.level(s["values"][model["names"][0]]) if s["id"] in named else ""
            marks.append(
                Mark(
                    id=s["id"],
                    x=px,
                    y=py,
                    half_x=hx,
                    half_y=hy,
                    color=color,
                    shape=shape,
                    text=text,
                    beside=beside,
                )
            )
    exact = f"exact_{cost}"
    line = float(ds[exact].mean()) if exact in ds else None
    return scatter(f"plot-{cost}", marks, cost, metric, line)


def _looks(model: dict[str, Any]) -> tuple[dict[str, tuple[str, str]], str]:
    """Colour and outline of each setting, by first and second swept parameter, and their legend."""
    names = model["names"][:2]
    levels = levels_of(model["settings"], names)
    look = looks_of(levels)

    def both(values: list[Any]) -> tuple[str, str]:
        color, marker = look(values)
        return color, SHAPES[marker]

    looks = {s["id"]: both([s["values"][n] for n in names]) for s in model["settings"]}
    rows = []
    for i, (name, values) in enumerate(zip(names, levels, strict=True)):
        if i and len(values) > MOST_MARKERS:
            continue
        named = values if len(values) <= MOST_NAMED else [values[0], values[-1]]
        row = ""
        for j, value in enumerate(named):
            color, shape = both([value if k == i else known[0] for k, known in enumerate(levels)])
            style = "" if i else f'fill="{color}"'
            shape = SHAPES[0] if i == 0 and len(levels) > 1 else shape
            more = " …" if named is not values and j == 0 else ""
            row += f'<span><svg viewBox="-8 -8 16 16"><path {style} d="{shape}"/></svg>'
            text = html.escape(labels.level(value))
            row += f"{labels.as_html(name, unit=False)} = {text}{more}</span>"
        rows.append(f'<p class="key">{row}</p>')
    line = '<svg viewBox="-8 -8 16 16"><path class="front" d="M-8 0H8"/></svg>'
    rows.append(f'<p class="key"><span>{line}Pareto front: nothing is better in both</span></p>')
    return looks, "".join(rows)


def _heatmap(model: dict[str, Any], ds: xarray.Dataset, value: str) -> str | None:
    """Means over all parameters except the first two; None if there are too many cells."""
    names = model["names"][:2]
    levels = levels_of(model["settings"], names)
    if len(levels[0]) * len(levels[1]) > MOST_CELLS:
        return None
    found: dict[tuple[int, int], list[tuple[float, str]]] = {}
    for s in model["settings"]:
        if s["cells"][value] and math.isfinite(s["cells"][value][0]):
            at = tuple(known.index(s["values"][n]) for n, known in zip(names, levels, strict=True))
            found.setdefault((at[0], at[1]), []).append((s["cells"][value][0], s["id"]))
    cells = {
        at: (math.fsum(v for v, _ in some) / len(some), some[0][1] if len(some) == 1 else None)
        for at, some in found.items()
    }
    along, up = ([labels.level(v) for v in known] for known in levels)
    drawn = heatmap(f"heatmap-{value}", (names[0], names[1]), (along, up), cells, value)
    return drawn if cells else None


def _dots(model: dict[str, Any], names: list[str], value: str) -> list[Dot]:
    return [
        Dot(id=s["id"], at={n: float(s["values"][n]) for n in names}, value=s["cells"][value][0])
        for s in model["settings"]
        if s["cells"][value] and math.isfinite(s["cells"][value][0])
    ]

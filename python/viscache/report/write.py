"""Writes a sweep as one HTML file that opens from disk and asks the network for nothing."""

from __future__ import annotations

import html
import json
import math
import os
import re
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING, Any

from viscache import plots
from viscache.checks import require
from viscache.report.embed import MOST_FLIP_MAPS, add_pictures
from viscache.report.svg import SHAPES, Mark, number, scatter
from viscache.store import Store
from viscache.sweep_table import open_dataset

if TYPE_CHECKING:
    import xarray

#: Where the gain of difference maps stands at first.
DIFFERENCE_GAIN = 16
#: The page's script, in order.
SCRIPTS = ("start.js", "pictures.js", "maps.js", "view.js", "viewer.js", "page.js")

_PLAIN = {
    "rel_l1": "relative error L̂_INF", "rmse": "RMSE", "rel_mse": "relative MSE",
    "energy": "energy error", "flip": "HDR-FLIP", "ssim": "SSIM", "max_abs": "largest error",
    "total_s": "time per frame [s]", "visibility_s": "visibility [s]", "cpu_s": "CPU [s]",
    "rays": "shadow rays", "queries": "queries", "ray_reduction": "queries per ray",
    "speedup": "speed-up over exact", "cpu_speedup": "CPU speed-up",
    "c_e": "C_E", "c_n": "C_N", "c_z": "C_Z", "c_r": "C_R",
    "n_vpls": "VPLs",
}  # fmt: skip


def write(
    sweep: xarray.Dataset | str | os.PathLike[str],
    path: str | os.PathLike[str] | None = None,
    *,
    flip_maps: int = MOST_FLIP_MAPS,
) -> Path:
    """Write the report of a sweep.

    Parameters
    ----------
    sweep : Dataset or path
        What `viscache.sweep` returned, or the directory it ran in. Pictures need the directory.
    path : path, optional
        The HTML file; `report.html` in the directory by default.
    flip_maps : int >= 0
        Most FLIP maps, which take seconds each; settings that nothing beats come first.

    Returns
    -------
    Path
        The file written.

    Raises
    ------
    ValueError
        No sweep there, or none of its points is finished; `flip_maps` below 0.
    """
    require(flip_maps >= 0, "flip_maps must be >= 0", flip_maps)
    if isinstance(sweep, (str, os.PathLike)):
        dataset = open_dataset(sweep)
        directory: Path | None = Path(sweep)
    else:
        dataset = sweep
        kept = dataset.attrs.get("directory")
        directory = Path(kept) if kept and Store.exists(kept) else None
    if path is not None:
        target = Path(path)
    elif directory is not None:
        target = directory / "report.html"
    else:
        raise ValueError("path must be given for a sweep without a directory")
    model = _model(dataset)
    if directory is not None:
        with Store(directory) as store:
            add_pictures(model, store, flip_maps)
    text = _page(model, dataset)
    partial = target.with_name(f".{target.name}.{os.getpid()}.part")
    partial.write_text(text, encoding="utf-8")
    partial.replace(target)
    return target


def _model(ds: xarray.Dataset) -> dict[str, Any]:
    """What the page shows, JSON-able."""
    metrics = json.loads(ds.attrs["metrics"])
    wanted = [
        *metrics[:1], "total_s", "speedup", "cpu_speedup", "rays", "ray_reduction", *metrics[1:],
        *(f"converged_{m}" for m in metrics[:1]), "visibility_s",
    ]  # fmt: skip
    columns = [c for c in wanted if c in ds and bool(ds[c].notnull().any())]
    if not columns or not metrics:
        raise ValueError("the sweep has no finished point")
    settings = plots.settings_of(ds, metrics[0])
    by_column = {c: {s["index"]: s[c] for s in plots.settings_of(ds, c)} for c in columns}
    names = list(settings[0]["values"]) if settings else []
    rows = []
    for i, setting in enumerate(settings):
        values = {k: v.item() if hasattr(v, "item") else v for k, v in setting["values"].items()}
        found = {c: by_column[c].get(setting["index"]) for c in columns}
        cells = {c: None if v is None else list(v) for c, v in found.items()}
        text = ", ".join(f"{_PLAIN.get(k, k)} = {v}" for k, v in values.items())
        rows.append({"id": f"s{i}", "index": list(setting["index"]), "values": values,
                     "cells": cells, "text": text})  # fmt: skip
    return {
        "names": names, "metrics": metrics, "columns": columns, "settings": rows,
        "labels": {n: plain(n) for n in [*names, *columns]}, "pictures": {},
        "size": json.loads(ds.attrs["size"]),
        "repeats": int(ds.sizes["repeat"]), "gain": DIFFERENCE_GAIN,
    }  # fmt: skip


def plain(name: str) -> str:
    """A column's words without markup."""
    if name.startswith("converged_"):
        return "total " + plain(name.removeprefix("converged_"))
    return _PLAIN.get(name, name)


def _page(model: dict[str, Any], ds: xarray.Dataset) -> str:
    pieces = {
        "TITLE": html.escape(f"{ds.attrs['scene']}: the trade of shadow rays for accuracy"),
        "SCENE": html.escape(str(ds.attrs["scene"])),
        "FACTS": _facts(ds, model),
        "PLOTS": _plots(model, ds),
        "TABLE": _table(model),
        "STYLE": _piece("style.css"),
        "SCRIPT": "\n".join(_piece(name) for name in SCRIPTS),
        "PIXELS": html.escape(_pixels_text(model)),
        "MOST_FLIP_MAPS": str(sum("flip" in s for s in model["settings"])),
        "DATA": json.dumps(model, allow_nan=False, default=str).replace("</", "<\\/"),
    }
    return re.sub(r"\{\{(\w+)\}\}", lambda found: pieces[found[1]], _piece("template.html"))


def _piece(name: str) -> str:
    return resources.files("viscache.report").joinpath("page", name).read_text("utf-8")


def _pixels_text(model: dict[str, Any]) -> str:
    """What the pictures' numbers are."""
    if not model["pictures"]:
        return ""
    (width, height), frame = model["size"], model["frame"]
    kept = "half floats"
    if model["step"] > 1:
        kept += f" whose errors are rounded to {model['step'] / 1024:.1%}"
    text = f"Pixels are linear radiance in {kept}; at 0 EV white is {model['white']:.4g}."
    if frame["width"] < width:
        shown = f"{frame['width']}×{frame['height']}"
        text += f" Frames of {width}×{height} are shown by means at {shown}."
    return text


def _facts(ds: xarray.Dataset, model: dict[str, Any]) -> str:
    """The header: what was rendered, with what, by which versions."""
    settings = {role: json.loads(ds.attrs[role]) for role in ("integrator", "visibility", "rays")}
    width, height = json.loads(ds.attrs["size"])
    made = json.loads(ds.attrs["provenance"])
    levels = {
        n: dict.fromkeys(str(s["values"][n]) for s in model["settings"]) for n in model["names"]
    }
    swept = "; ".join(f"{plain(n)} ∈ {{{', '.join(texts)}}}" for n, texts in levels.items())
    facts = {
        "Swept": swept,
        "Frame": f"{width}×{height}, {ds.attrs['spp']} sample(s) per pixel, "
        f"{model['repeats']} repeat(s)",
        **{role.capitalize(): _settings_text(table) for role, table in settings.items()},
        "Scene hash": str(ds.attrs["scene_hash"])[:16],
        "Made by": ", ".join(f"{k} {v}" for k, v in made.items() if k != "date"),
        "Processor": str(ds.attrs["cpu"]),
        "Date": str(made.get("date", "unknown")),
    }
    return "".join(
        f"<div><dt>{html.escape(k)}</dt><dd>{html.escape(v)}</dd></div>" for k, v in facts.items()
    )


def _settings_text(table: dict[str, Any]) -> str:
    rest = ", ".join(f"{k} = {v}" for k, v in table.items() if k != "name" and v not in (None, {}))
    return f"{table['name']}" + (f" ({rest})" if rest else "")


def _plots(model: dict[str, Any], ds: xarray.Dataset) -> str:
    metric = model["metrics"][0]
    looks, key = _looks(model)
    figures = []
    for column, exact in (("total_s", "exact_total_s"), ("rays", "exact_rays")):
        if column not in model["columns"]:
            continue
        marks = []
        for s in model["settings"]:
            (px, hx), (py, hy) = s["cells"][column] or (math.nan, 0), s["cells"][metric]
            if math.isfinite(px):
                color, shape = looks[s["id"]]
                text = f"{s['text']}: {plain(metric)} {py:.4g}, {plain(column)} {number(px)}"
                marks.append(Mark(id=s["id"], x=px, y=py, half_x=hx, half_y=hy, color=color,
                                  shape=shape, text=text))  # fmt: skip
        line = float(ds[exact].mean()) if exact in ds else None
        svg = scatter(f"plot-{column}", marks, plain(column), plain(metric), line)
        figures.append(f"<figure>{svg}</figure>")
    return f'<div class="plots">{"".join(figures)}</div>{key}'


def _looks(model: dict[str, Any]) -> tuple[dict[str, tuple[str, str]], str]:
    """Colour and outline of each setting, by first and second swept parameter, and their key."""
    names = model["names"][:2]
    levels = [list(dict.fromkeys(str(s["values"][n]) for s in model["settings"])) for n in names]
    colors = plots.colors_for(len(levels[0]) if levels else 1)
    looks = {}
    for s in model["settings"]:
        at = [texts.index(str(s["values"][n])) for n, texts in zip(names, levels, strict=True)]
        first, second = [*at, 0, 0][:2]
        looks[s["id"]] = (colors[first], SHAPES[second % len(SHAPES)])
    rows = []
    for i, (name, texts) in enumerate(zip(names, levels, strict=True)):
        row = ""
        for j, text in enumerate(texts):
            shape, style = SHAPES[j % len(SHAPES) if i else 0], "" if i else f'fill="{colors[j]}"'
            row += f'<span><svg viewBox="-8 -8 16 16"><path {style} d="{shape}"/></svg>'
            row += html.escape(f"{plain(name)} = {text}") + "</span>"
        rows.append(f'<p class="key">{row}</p>')
    return looks, "".join(rows)


def _table(model: dict[str, Any]) -> str:
    heads = [*model["names"], *model["columns"]]
    head = "".join(
        f'<th scope="col" data-column="{html.escape(h)}">'
        f"<button>{html.escape(plain(h))}</button></th>"
        for h in heads
    )
    rows = []
    for s in model["settings"]:
        cells = [f"<td>{html.escape(str(s['values'][n]))}</td>" for n in model["names"]]
        for column in model["columns"]:
            cell = s["cells"][column]
            if cell is None:
                cells.append('<td data-value="">–</td>')
                continue
            mean, half = cell
            spread = f" <small>± {number(float(f'{half:.2g}'))}</small>" if half else ""
            cells.append(f'<td data-value="{mean!r}">{number(mean)}{spread}</td>')
        rows.append(f'<tr data-id="{s["id"]}" tabindex="0">{"".join(cells)}</tr>')
    return (
        f'<table id="settings"><thead><tr>{head}</tr></thead><tbody>{"".join(rows)}</tbody></table>'
    )

"""Writes a sweep as one HTML file that opens from disk and asks the network for nothing."""

from __future__ import annotations

import html
import json
import os
import re
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING, Any

from viscache import labels
from viscache.checks import require
from viscache.labels import number, plain
from viscache.report import draw
from viscache.report.embed import MOST_FLIP_MAPS, add_pictures
from viscache.store import Store
from viscache.sweep_table import open_dataset
from viscache.swept import MOST_NAMED, levels_of, settings_of

if TYPE_CHECKING:
    import xarray

#: Where the gain of difference maps stands at first.
DIFFERENCE_GAIN = 16
#: The page's script, in order.
SCRIPTS = ("start.js", "pictures.js", "maps.js", "view.js", "viewer.js", "page.js")


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
    settings = settings_of(ds, metrics[0])
    by_column = {c: {s["index"]: s[c] for s in settings_of(ds, c)} for c in columns}
    names = list(settings[0]["values"]) if settings else []
    rows = []
    for i, setting in enumerate(settings):
        values = {k: v.item() if hasattr(v, "item") else v for k, v in setting["values"].items()}
        found = {c: by_column[c].get(setting["index"]) for c in columns}
        cells = {c: None if v is None else list(v) for c, v in found.items()}
        text = ", ".join(f"{plain(k, unit=False)} = {labels.level(v)}" for k, v in values.items())
        rows.append({"id": f"s{i}", "index": list(setting["index"]), "values": values,
                     "cells": cells, "text": text})  # fmt: skip
    return {
        "names": names, "metrics": metrics, "columns": columns, "settings": rows,
        "labels": {n: plain(n) for n in [*names, *columns]}, "pictures": {},
        "size": json.loads(ds.attrs["size"]),
        "repeats": int(ds.sizes["repeat"]), "gain": DIFFERENCE_GAIN,
    }  # fmt: skip


def _page(model: dict[str, Any], ds: xarray.Dataset) -> str:
    pieces = {
        "TITLE": html.escape(f"{ds.attrs['scene']}: the trade of shadow rays for accuracy"),
        "SCENE": html.escape(str(ds.attrs["scene"])),
        "FACTS": _facts(ds, model),
        "PLOTS": draw.plots(model, ds),
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
    found = zip(model["names"], levels_of(model["settings"], model["names"]), strict=True)
    swept = "; ".join(_levels_text(name, levels) for name, levels in found)
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


def _levels_text(name: str, levels: list[Any]) -> str:
    """A swept parameter and its values, or how many there are."""
    words, texts = plain(name, unit=False), [labels.level(v) for v in levels]
    if len(levels) > MOST_NAMED:
        return f"{words}: {len(levels)} values from {texts[0]} to {texts[-1]}"
    return f"{words} ∈ {{{', '.join(texts)}}}"


def _settings_text(table: dict[str, Any]) -> str:
    rest = ", ".join(f"{k} = {v}" for k, v in table.items() if k != "name" and v not in (None, {}))
    return f"{table['name']}" + (f" ({rest})" if rest else "")


def _table(model: dict[str, Any]) -> str:
    heads = [*model["names"], *model["columns"]]
    head = "".join(
        f'<th scope="col" data-column="{html.escape(h)}"><button>{labels.as_html(h)}</button></th>'
        for h in heads
    )
    rows = []
    for s in model["settings"]:
        cells = [f"<td>{html.escape(labels.level(s['values'][n]))}</td>" for n in model["names"]]
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

"""Writes a sweep as one self-contained HTML file that needs no network."""

from __future__ import annotations

import html
import json
import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

from viscache.base.progress import Progress
from viscache.plots import labels
from viscache.plots.labels import plain
from viscache.report import assemble, draw
from viscache.report.assemble import write_page
from viscache.report.costs import Offer, Verdict, knee, verdict
from viscache.report.embed import MOST_FLIP_MAPS, add_pictures
from viscache.report.pictures import MAX_WIDTH_PX
from viscache.settings.checks import require
from viscache.sweeps.store import Store
from viscache.sweeps.swept import MOST_NAMED, error_of, levels_of, settings_of
from viscache.sweeps.table import folder_of, open_dataset

if TYPE_CHECKING:
    import xarray

_NOTES = (
    "Means over repeats ± half of the 95 % confidence interval (Student's t). Errors are against "
    "the exact frame of equal seed and samples; “total” errors are against the converged reference."
)


def write(
    sweep: xarray.Dataset | str | os.PathLike[str],
    path: str | os.PathLike[str] | None = None,
    *,
    error: str | None = None,
    target: float | None = None,
    flip_maps: int = MOST_FLIP_MAPS,
    width: int = MAX_WIDTH_PX,
    progress: Progress = False,
) -> Path:
    """Write the report of a sweep.

    Parameters
    ----------
    sweep : Dataset or path
        The result of `viscache.sweep`, or its directory. Pictures require the directory, or a sweep
        that this process ran or opened.
    path : path, optional
        The HTML file; `report.html` in the directory by default.
    error : str, optional
        The metric of the verdict, of the plots and of the first column of errors; the sweep's first
        by default.
    target : float > 0, optional
        The wanted error. The verdict begins with it, and the page opens on the cheapest setting of
        at most this error. Without it, the verdict begins with 1 %, and the page opens on the knee
        of the Pareto front.
    flip_maps : int >= 0
        Maximum number of FLIP maps, which take seconds each; Pareto-optimal settings come first.
        Finished maps are kept in the directory of the sweep.
    width : int >= 1
        Maximum width; wider frames are shown as means over pixels.
    progress : bool or callable
        True shows a progress bar; a callable is called with (done, total) settings.

    Returns
    -------
    Path
        The file written.

    Raises
    ------
    ValueError
        There is no sweep, or none of its points is finished; it has no metric `error`; `target` is
        not above 0, `flip_maps` is below 0, or `width` below 1.
    """
    require(flip_maps >= 0, "flip_maps must be >= 0", flip_maps)
    require(width >= 1, "width must be >= 1", width)
    if isinstance(sweep, (str, os.PathLike)):
        dataset = open_dataset(sweep)
        directory: Path | None = Path(sweep)
    else:
        dataset = sweep
        directory = folder_of(dataset)
    if path is not None:
        page = Path(path)
    elif directory is not None:
        page = directory / "report.html"
    else:
        raise ValueError("path must be given for a sweep without a directory")
    model = _model(dataset, error)
    found = verdict(dataset, error, target)
    model["opens"] = _opening(model, target)
    if directory is not None:
        with Store(directory) as store:
            add_pictures(model, store, flip_maps, width, progress)
    scene = html.escape(str(dataset.attrs["scene"]))
    texts = {
        "TITLE": f"{scene}: the trade of shadow rays for accuracy",
        "HEADING": scene,
        "SUBTITLE": "Shadow rays traded for accuracy, and what the trade costs",
        "VERDICT": "" if found is None else _verdict(model, found, str(dataset.attrs["cpu"])),
        "FACTS": _facts(dataset, model),
        "PLOTS": "<h2>The trade</h2>" + draw.plots(model, dataset),
        "TABLE_HEADING": "Every setting",
        "NOTES": _NOTES,
    }
    write_page(page, model, texts)
    return page


def _model(ds: xarray.Dataset, error: str | None) -> dict[str, Any]:
    """The data that the page shows, for JSON."""
    known = json.loads(ds.attrs["metrics"])
    first = error_of(ds, error)
    metrics = [first, *(m for m in known if m != first)]
    wanted = [
        *metrics[:1],
        "total_s",
        "speedup",
        "cpu_speedup",
        "rays",
        "ray_reduction",
        *metrics[1:],
        *(f"converged_{m}" for m in metrics[:1]),
        "visibility_s",
    ]
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
        text = labels.setting(values)
        row: dict[str, Any] = {"id": f"s{i}", "index": list(setting["index"])}
        rows.append(row | {"values": values, "cells": cells, "text": text})
    width, height = json.loads(ds.attrs["size"])
    return {
        "names": names,
        "metrics": metrics,
        "columns": columns,
        "settings": rows,
        "pictures": {},
        "size": [width, height],
        "frame": {"width": width, "height": height},
        "repeats": int(ds.sizes["repeat"]),
    }


def _opening(model: dict[str, Any], target: float | None) -> str | None:
    """The setting that the page shows first: the best for the target, or the front's knee."""
    metric = model["metrics"][0]
    cost = next((c for c in ("total_s", "rays") if c in model["columns"]), None)
    if cost is None:
        return None
    shown = [s for s in model["settings"] if s["cells"][cost] and s["cells"][metric]]
    places = [(s["cells"][cost][0], s["cells"][metric][0]) for s in shown]
    if not shown:
        return None
    if target is not None and any(y <= target for _, y in places):
        chosen = min(range(len(shown)), key=lambda i: (places[i][1] > target, places[i]))
    else:
        chosen = (
            knee(places) if target is None else min(range(len(shown)), key=lambda i: places[i][1])
        )
    return str(shown[chosen]["id"])


def _verdict(model: dict[str, Any], found: Verdict, cpu: str) -> str:
    """The verdict as HTML; its settings are buttons that choose them."""
    ids = {tuple(s["index"]): s["id"] for s in model["settings"]}

    def button(offer: Offer) -> str:
        words = ", ".join(
            f"{labels.as_html(k, unit=False)} = {html.escape(labels.level(v))}"
            for k, v in offer.values.items()
        )
        return f'<button class="choose" data-id="{ids[offer.index]}">{words}</button>'

    first, *more = found.sentences(button)
    rest = f"<p>{' '.join(more)}</p>" if more else ""
    return (
        f'<section class="verdict" aria-label="Verdict"><p class="first">{first}</p>{rest}'
        f'<p class="quiet">Errors are {labels.as_html(found.metric)} against exact visibility. '
        "Times are wall seconds of a frame without building its ray caster, all of this sweep, on "
        f"{html.escape(cpu)}.</p></section>"
    )


def _facts(ds: xarray.Dataset, model: dict[str, Any]) -> str:
    """The header: scene, settings and versions."""
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
    return assemble.facts(facts)


def _levels_text(name: str, levels: list[Any]) -> str:
    """A swept parameter and its values, or their number."""
    words, texts = plain(name, unit=False), [labels.level(v) for v in levels]
    if len(levels) > MOST_NAMED:
        return f"{words}: {len(levels)} values from {texts[0]} to {texts[-1]}"
    return f"{words} ∈ {{{', '.join(texts)}}}"


def _settings_text(table: dict[str, Any]) -> str:
    rest = ", ".join(f"{k} = {v}" for k, v in table.items() if k != "name" and v not in (None, {}))
    return f"{table['name']}" + (f" ({rest})" if rest else "")

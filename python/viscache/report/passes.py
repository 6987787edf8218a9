"""A page of passes: error over time of settings side by side, and their pictures."""

from __future__ import annotations

import html
import json
import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from viscache.passes.over_time import ERRORS
from viscache.report import assemble, pictures
from viscache.report.assemble import write_page
from viscache.report.embed import Packer
from viscache.report.pictures import MAX_WIDTH_PX
from viscache.report.svg import SHAPES
from viscache.report.svg_curves import Curve, curves
from viscache.settings.checks import require
from viscache.sweeps.swept import colors_for

if TYPE_CHECKING:
    import xarray

COLUMNS = (*ERRORS, "cpu_s", "wall_s", "rays")
_NOTES = (
    "Errors are of light on surfaces after the last pass. Times and rays are of all passes. A ± is"
    " half of the 95 % interval over blocks of the picture."
)


def write_passes(
    ds: xarray.Dataset,
    path: str | os.PathLike[str],
    *,
    flip_map: bool = True,
    width: int = MAX_WIDTH_PX,
) -> Path:
    """Write error over time of several settings, and their pictures, as one HTML file.

    Parameters
    ----------
    ds : Dataset of `viscache.passes_over_time`
    path : path
        The HTML file.
    flip_map : bool
        Include FLIP maps, which take seconds each.
    width : int >= 1
        Maximum width; wider pictures are shown as means over pixels.

    Returns
    -------
    Path
        The file written.

    Raises
    ------
    ValueError
        The dataset is not one of passes, or `width` is below 1.

    Examples
    --------
    >>> import tempfile, viscache as vc
    >>> ds = vc.passes_over_time(
    ...     "room?triangles=3000", vc.Whitted(n_vpls=16), passes=2, size=(48, 32)
    ... )
    >>> vc.report.write_passes(ds, tempfile.mkdtemp() + "/passes.html", flip_map=False).name
    'passes.html'
    """
    require(width >= 1, "width must be >= 1", width)
    fits = {"setting", "pass"} <= set(ds.dims) and "picture" in ds
    require(fits, "ds must be a dataset of vc.passes_over_time", list(ds.dims))
    names = [str(n) for n in ds["setting"].values]
    known = json.loads(ds.attrs["settings"])
    size, passes = json.loads(ds.attrs["size"]), int(ds.sizes["pass"])
    settings: list[dict[str, Any]] = [
        {
            "id": f"s{i}",
            "index": [i],
            "text": name,
            "values": {"setting": name},
            "parameters": known[name],
            "sha256": None,
            "cells": {c: _cell(ds, name, c) for c in COLUMNS},
        }
        for i, name in enumerate(names)
    ]
    model: dict[str, Any] = {
        "names": ["setting"],
        "metrics": list(ERRORS),
        "columns": list(COLUMNS),
        "settings": settings,
        "pictures": {},
        "size": size,
        "frame": {"width": size[0], "height": size[1]},
        "repeats": 1,
    }
    packer, truth = Packer(model, len(names), width), ds["reference"].values.astype(np.float64)
    for setting, name in zip(settings, names, strict=True):
        image = ds["picture"].sel(setting=name).values.astype(np.float64)
        packer.add(setting, image, truth, "reference")
        if flip_map:
            setting["flip"] = pictures.flip_map(image, truth, width)
    scene = html.escape(str(ds.attrs["scene"]))
    texts = {
        "TITLE": f"{scene}: error over time",
        "HEADING": scene,
        "SUBTITLE": "Biased, corrected and exact visibility, pass by pass",
        "FACTS": assemble.facts(_facts(ds, passes)),
        "PLOTS": "<h2>Error over time</h2>" + _plots(ds, names),
        "TABLE_HEADING": f"After {passes} passes",
        "NOTES": _NOTES,
    }
    target = Path(path)
    write_page(target, model, texts)
    return target


def _cell(ds: xarray.Dataset, name: str, column: str) -> list[float]:
    last = ds.sel(setting=name).isel({"pass": -1})
    half = float(last["nmse_high"] - last["nmse"]) if column == "nmse" else 0.0
    return [float(last[column]), half]


def _plots(ds: xarray.Dataset, names: list[str]) -> str:
    """Squared error over time and over passes, and the legend."""
    looks = list(zip(names, colors_for(len(names)), strict=False))

    def drawn(x: str, y: str) -> str:
        found = [
            Curve(
                id=f"s{i}",
                x=[float(v) for v in (ds[x] if x == "pass" else ds[x].sel(setting=n))],
                y=[float(v) for v in ds[y].sel(setting=n)],
                color=color,
                shape=SHAPES[i % len(SHAPES)],
                text=n,
            )
            for i, (n, color) in enumerate(looks)
        ]
        return f"<figure>{curves(f'plot-{x}-{y}', found, x, y)}</figure>"

    key = "".join(
        f'<span><svg viewBox="-8 -8 16 16"><path fill="{color}" d="{SHAPES[i % len(SHAPES)]}"/>'
        f"</svg>{html.escape(name)}</span>"
        for i, (name, color) in enumerate(looks)
    )
    both = drawn("cpu_s", "nmse") + drawn("pass", "rel_mse")
    return f'<div class="plots">{both}</div><p class="key">{key}</p>'


def _facts(ds: xarray.Dataset, passes: int) -> dict[str, str]:
    made, size = json.loads(ds.attrs["provenance"]), json.loads(ds.attrs["size"])
    words = f"2 × {ds.attrs['reference_passes']} exact passes of other eye samples"
    return {
        "Passes": f"{passes} of {ds.attrs['spp']} sample(s) per pixel, {size[0]}×{size[1]}",
        "Reference": words if ds.attrs["reference_passes"] else "given",
        "Integrator": str(ds.attrs["integrator"]),
        "Scene hash": str(ds.attrs["scene_hash"])[:16],
        "Made by": ", ".join(f"{k} {v}" for k, v in made.items() if k != "date"),
        "Date": str(made.get("date", "unknown")),
    }

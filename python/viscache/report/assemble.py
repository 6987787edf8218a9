"""Assembles a page: template, style, script, table and data in one file."""

from __future__ import annotations

import html
import json
import re
from collections.abc import Mapping
from importlib import resources
from pathlib import Path
from typing import Any

from viscache.base.files import write_whole
from viscache.plots import labels
from viscache.plots.labels import number

#: Initial gain of difference maps.
DIFFERENCE_GAIN = 16
#: Files of the page's script, in order.
SCRIPTS = ("start.js", "pictures.js", "maps.js", "view.js", "viewer.js", "roving.js", "page.js")


def write_page(target: Path, model: dict[str, Any], texts: Mapping[str, str]) -> None:
    """Write a page from data for its script and from HTML for the template's places.

    The data: names, columns, settings, pictures (`embed.Packer`), size. The places: TITLE, HEADING,
    SUBTITLE, FACTS, PLOTS, TABLE_HEADING, NOTES, and VERDICT where there is one.
    """
    pieces = {
        "VERDICT": "",
        **texts,
        "TABLE": _table(model),
        "STYLE": _piece("style.css"),
        "SCRIPT": "\n".join(_piece(name) for name in SCRIPTS),
        "PIXELS": html.escape(_pixels_text(model)),
        "FLIP_MAPS": str(sum("flip" in s for s in model["settings"])),
        "DATA": json.dumps(
            {"gain": DIFFERENCE_GAIN, **model}, allow_nan=False, default=str
        ).replace("<", "\\u003c"),
    }
    text = re.sub(r"\{\{(\w+)\}\}", lambda found: pieces[found[1]], _piece("template.html"))
    write_whole(target, text)


def facts(table: Mapping[str, str]) -> str:
    """The rows of a page's header."""
    return "".join(
        f"<div><dt>{html.escape(k)}</dt><dd>{html.escape(v)}</dd></div>" for k, v in table.items()
    )


def _piece(name: str) -> str:
    return resources.files("viscache.report").joinpath("page", name).read_text("utf-8")


def _pixels_text(model: dict[str, Any]) -> str:
    """Explains the pixel values of the pictures."""
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
        rows.append(f'<tr data-id="{s["id"]}">{"".join(cells)}</tr>')
    return (
        f'<table id="settings" role="grid"><thead><tr>{head}</tr></thead>'
        f"<tbody>{''.join(rows)}</tbody></table>"
    )

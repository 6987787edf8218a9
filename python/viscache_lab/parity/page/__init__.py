"""The HTML page of a parity run: verdicts first, pictures folded; it needs no other files."""

from __future__ import annotations

import base64
import html
import io
import json
import math
from collections import Counter
from collections.abc import Mapping, Sequence
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from viscache.base import tonemap
from viscache.base.files import write_whole
from viscache.report.assemble import facts
from viscache.report.pictures import scale_colors
from viscache_lab.experiment.page import document
from viscache_lab.parity.judge import VERDICTS, Judged

__all__ = ["write_page"]

#: Ends of the colour scales: relative to display white, and standard deviations.
FULL_DIFFERENCE, FULL_Z = 0.25, 6.0
#: Colours of each picture; this makes them small enough to embed hundreds.
PALETTE = 128

#: How to read the page.
_READ = (
    '<p class="quiet">A block of pixels agrees within 3 σ + 1 %, where σ comes from pictures of'
    " independent seeds. A scene agrees if 95 % of its blocks do and its energy is within 3 σ +"
    " 1 %. <b>Finds</b> is the relative difference of a block that would have been found at 95 %:"
    " the median over the lit blocks. Choose a row to see its pictures; a heading sorts.</p>"
)
_HEADS = ("scene", "verdict", "blocks within", "worst z", "energy", "finds", "pictures", "why")


def write_page(target: Path, results: Sequence[Judged], about: Mapping[str, str]) -> None:
    """Write the page; `about` has the rows of its head."""
    sizes = {r.name: abs(r.compared.worst_z) if r.compared else 0.0 for r in results}
    ordered = sorted(results, key=lambda r: (VERDICTS.index(r.verdict), -sizes[r.name], r.name))
    pictures = json.dumps({"pictures": {r.name: _pictures(r) for r in ordered}})
    parts = [
        "<p>Direct light of viscache and of Mitsuba 3 on the same files, or of a formula"
        ' <button class="tool" id="theme" type="button">Dark / light</button></p>',
        f'<dl class="facts">{facts(about)}</dl>',
        f'<div class="verdicts" role="group" aria-label="Verdicts">{_counts(results)}</div>',
        '<div class="tools above"><label>Find <input id="find" type="search"'
        ' placeholder="name or warning"></label><output id="shown"></output></div>',
        '<div class="scroll"><table id="scenes"><thead><tr>',
        *(f'<th scope="col"><button>{head}</button></th>' for head in _HEADS),
        "</tr></thead>",
        *map(_row, ordered),
        f"</table></div>{_READ}",
    ]
    lab = "viscache_lab.parity"
    style = _file("viscache.report", "page/style.css") + _file(lab, "page/parity.css")
    script = _file(lab, "page/parity.js")
    title = "Does my scene come out right?"
    write_whole(target, document(title, parts, style=style, script=script, data=pictures))


def _file(package: str, path: str) -> str:
    return resources.files(package).joinpath(path).read_text("utf-8")


def _counts(results: Sequence[Judged]) -> str:
    counts = Counter(r.verdict for r in results)
    return "".join(
        f'<button class="tool verdict {_class(v)}" aria-pressed="true" data-verdict="{_class(v)}">'
        f"{v} <b>{counts[v]}</b></button>"
        for v in VERDICTS
    )


def _row(result: Judged) -> str:
    c = result.compared
    cells = [
        f'<td class="name">{html.escape(result.name)}</td>',
        f'<td data-value="{VERDICTS.index(result.verdict)}"><span class="verdict '
        f'{_class(result.verdict)}">{result.verdict}</span></td>',
        *_numbers(result),
        f'<td class="why">{html.escape(result.why or result.about)}</td>',
    ]
    said = [result.about] if result.about else []
    said += [f"viscache: {text}" for text in result.warnings]
    said += [f"Mitsuba: {text}" for text in result.mitsuba]
    other = "right" if result.about else "Mitsuba"
    said += [] if c is None else [f"energy {c.energy_ours:.5g}, {other} {c.energy_theirs:.5g}"]
    lines = "".join(f"<li>{html.escape(text)}</li>" for text in said)
    return (
        f'<tbody data-name="{html.escape(result.name)}" data-verdict="{_class(result.verdict)}">'
        f'<tr class="scene" tabindex="0" aria-expanded="false">{"".join(cells)}</tr>'
        f'<tr hidden><td colspan="{len(_HEADS)}"><div class="shots"></div>'
        f"<ul>{lines}</ul></td></tr></tbody>"
    )


def _numbers(result: Judged) -> list[str]:
    """Cells that sort by their values; not-finite ones are greatest."""
    c = result.compared
    if c is None:
        return ['<td class="number" data-value="">–</td>'] * 5
    values = [
        (c.share, f"{c.share:.1%}"),
        (abs(c.worst_z), f"{c.worst_z:+.1f}"),
        (abs(c.energy_difference), f"{c.energy_difference:+.2%}"),
        (c.power, f"{c.power:.1%}"),
        (float(result.pictures), str(result.pictures)),
    ]
    return [
        f'<td class="number" data-value="{v if math.isfinite(v) else 1e30!r}">{text}</td>'
        for v, text in values
    ]


def _class(verdict: str) -> str:
    return verdict.replace(" ", "-")


def _pictures(result: Judged) -> list[str]:
    """Both pictures, their signed difference and the z of each block, as PNG."""
    if result.compared is None or result.ours is None or result.theirs is None:
        return []
    brighter = result.theirs if result.theirs.max() > 0 else result.ours
    exposure = tonemap.display_exposure(brighter)
    difference = tonemap.luminance(np.nan_to_num(result.ours) - result.theirs) * exposure
    z = result.compared.z
    largest = np.take_along_axis(z, np.abs(z).argmax(axis=2)[..., None], axis=2)[..., 0]
    return [
        _png(tonemap.to_srgb8(result.ours, exposure)),
        _png(tonemap.to_srgb8(result.theirs, exposure)),
        _png(_signed(difference / FULL_DIFFERENCE)),
        _png(_signed(largest / FULL_Z)),
    ]


def _signed(values: npt.NDArray[Any]) -> npt.NDArray[np.uint8]:
    """Colours of values in [-1, 1]: blue, white, red."""
    steps = np.round(127.5 + 127.5 * np.clip(values, -1.0, 1.0)).astype(np.intp)
    return np.asarray(scale_colors("RdBu_r")[steps])


def _png(pixels: npt.NDArray[np.uint8]) -> str:
    from PIL import Image

    buffer = io.BytesIO()
    reduced = Image.fromarray(pixels).quantize(PALETTE, dither=Image.Dither.NONE)
    reduced.save(buffer, "PNG", optimize=True)
    return base64.b64encode(buffer.getvalue()).decode("ascii")

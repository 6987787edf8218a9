"""The page and the file of `viscache bench peers -o DIR`; the page needs no other files."""

from __future__ import annotations

import html
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from viscache.base.files import write_whole
from viscache_lab.experiment.page import document

_HEADS = ("case", "viscache", "peer", "unit", "faster at equal samples", "faster to equal error")


def write_pages(folder: Path, result: Mapping[str, Any]) -> None:
    """Write `index.html` and `peers.json`, the object of `--json`, into a folder."""
    folder.mkdir(parents=True, exist_ok=True)
    write_whole(folder / "index.html", page(result))
    write_whole(folder / "peers.json", json.dumps(result, indent=1) + "\n")


def page(result: Mapping[str, Any]) -> str:
    """The figures of a run as one page of HTML: a table, what was skipped, what was wrong."""
    machine, answers = result["machine"], result["answers"]
    wrong = [a for a in answers if not a["holds"]]
    about = f"{machine['processor']}, {machine['cores']} cores, load {machine['load']}. "
    about += f"{len(answers)} answers checked, {len(wrong)} wrong."
    wrongs = [f"{a['what']}: {a['value']:.3g}, at most {a['limit']:.3g}" for a in wrong]
    skips = [f"{s['what']}: {s['reason']}" for s in result["skipped"]]
    parts = [
        *(f"<p>{html.escape(text)}</p>" for text in (about, *result["notes"])),
        '<div class="scroll" tabindex="0" role="region" aria-label="Figures"><table><thead><tr>',
        *(f'<th scope="col">{head}</th>' for head in _HEADS),
        "</tr></thead><tbody>",
        *map(_row, result["figures"]),
        "</tbody></table></div>",
        *_list("Wrong answers", wrongs),
        *_list("Skipped", skips),
    ]
    return document("viscache beside other renderers", parts)


def _row(f: Mapping[str, Any]) -> str:
    ratio, equal = _times(f, "ratio", "low", "high"), _times(f, "equal_error")
    if f.get("rel_l1") is not None:
        equal = f"rel_l1 {f['rel_l1']:.4f}"
    if f.get("build_s") is not None:
        ratio += f", without its build {f['ratio_without_build']:.2f}"
    if f.get("equal_error_without_build") is not None:
        equal += f", without its build {f['equal_error_without_build']:.2f}"
    name, unit = html.escape(f"{f['name']} {f.get('version', '')}".rstrip()), html.escape(f["unit"])
    cells = (f"{f['value']:.4g}", f"{f['baseline']:.4g}", unit, ratio, equal)
    numbers = "".join(f'<td class="number">{cell}</td>' for cell in cells)
    return f'<tr><th scope="row">{name}</th>{numbers}</tr>'


def _times(f: Mapping[str, Any], key: str, low: str = "", high: str = "") -> str:
    """A ratio with its ends; nothing where there is none."""
    if f.get(key) is None:
        return ""
    return f"{f[key]:.2f} [{f[low or f'{key}_low']:.2f}, {f[high or f'{key}_high']:.2f}]"


def _list(title: str, items: Sequence[str]) -> list[str]:
    lines = [f"<li>{html.escape(item)}</li>" for item in items]
    return [f"<h2>{title}</h2><ul>", *lines, "</ul>"] if items else []

"""The page and the file of `viscache bench peers -o DIR`; the page needs no other files."""

from __future__ import annotations

import html
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from viscache.base.files import write_whole

_STYLE = (
    ":root{color-scheme:light dark}body{font:1rem/1.5 system-ui,sans-serif;max-width:70rem;"
    "margin:auto;padding:1rem}.wide{overflow-x:auto}table{border-collapse:collapse}"
    "th,td{padding:.25rem .75rem;text-align:left;border-bottom:1px solid #8886}"
    "td.n{text-align:right;font-variant-numeric:tabular-nums}"
)
_HEADS = ("case", "viscache", "peer", "unit", "faster at equal samples", "faster to equal error")


def write_pages(folder: Path, result: Mapping[str, Any]) -> None:
    """Write `index.html` and `peers.json`, the object of `--json`, into a folder."""
    folder.mkdir(parents=True, exist_ok=True)
    write_whole(folder / "index.html", page(result))
    write_whole(folder / "peers.json", json.dumps(result, indent=1) + "\n")


def page(result: Mapping[str, Any]) -> str:
    """The figures of a run as one page of HTML: a table, what was skipped, what was wrong."""
    machine = result["machine"]
    wrong = [a for a in result["answers"] if not a["holds"]]
    count = len(result["answers"])
    parts = [
        '<!doctype html><html lang="en"><head><meta charset="utf-8">',
        '<meta name="viewport" content="width=device-width"><link rel="icon" href="data:,">',
        f"<title>viscache beside other renderers</title><style>{_STYLE}</style></head><body><main>",
        "<h1>viscache beside other renderers</h1>",
        _paragraph(
            f"{machine['processor']}, {machine['cores']} cores, load {machine['load']}."
            f" {count} answers checked, {len(wrong)} wrong."
        ),
        *(_paragraph(note) for note in result["notes"]),
        '<div class="wide" tabindex="0" role="region" aria-label="Figures"><table><thead><tr>',
        *(f'<th scope="col">{head}</th>' for head in _HEADS),
        "</tr></thead><tbody>",
        *(_row(f) for f in result["figures"]),
        "</tbody></table></div>",
    ]
    wrongs = [f"{a['what']}: {a['value']:.3g}, at most {a['limit']:.3g}" for a in wrong]
    skips = [f"{s['what']}: {s['reason']}" for s in result["skipped"]]
    parts += _list("Wrong answers", wrongs) + _list("Skipped", skips)
    return "".join(parts) + "</main></body></html>\n"


def _row(f: Mapping[str, Any]) -> str:
    equal = ""
    if f.get("equal_error") is not None:
        equal = _times(f["equal_error"], f["equal_error_low"], f["equal_error_high"])
    elif f.get("rel_l1") is not None:
        equal = f"rel_l1 {f['rel_l1']:.4f}"
    ratio = _times(f["ratio"], f["low"], f["high"])
    if f.get("build_s") is not None:
        ratio += f", without its build {f['ratio_without_build']:.2f}"
    if f.get("equal_error_without_build") is not None:
        equal += f", without its build {f['equal_error_without_build']:.2f}"
    numbers = f"{f['value']:.4g}", f"{f['baseline']:.4g}"
    name = html.escape(f"{f['name']} {f.get('version', '')}".rstrip())
    cells = "".join(f'<td class="n">{n}</td>' for n in numbers)
    return (
        f'<tr><th scope="row">{name}</th>{cells}<td>{html.escape(f["unit"])}</td>'
        f'<td class="n">{ratio}</td><td class="n">{equal}</td></tr>'
    )


def _times(value: float, low: float, high: float) -> str:
    return f"{value:.2f} [{low:.2f}, {high:.2f}]"


def _paragraph(text: str) -> str:
    return f"<p>{html.escape(text)}</p>"


def _list(title: str, items: list[str]) -> list[str]:
    if not items:
        return []
    return [f"<h2>{title}</h2><ul>", *(f"<li>{html.escape(i)}</li>" for i in items), "</ul>"]

"""One HTML page of all figures, with all rows and pictures."""

from __future__ import annotations

import base64
import html as _html
import io
import math
from collections.abc import Iterable, Mapping
from functools import lru_cache
from pathlib import Path
from typing import Any

from viscache_lab.experiment.claim_rules import interval
from viscache_lab.experiment.registry import FIGURES
from viscache_lab.experiment.verdict import claim_of, sentence

#: Above this many bytes, a picture is reduced to this many pixels in width.
LARGE_BYTES, WIDTH_PX = 400_000, 1600

_STYLE = """
:root { color-scheme: light dark; }
body { font: 15px/1.45 system-ui, "DejaVu Sans", sans-serif; max-width: 1200px; margin: 24px auto;
  padding: 0 20px; }
table { border-collapse: collapse; font-size: 13px; font-variant-numeric: tabular-nums;
  width: 100%; }
th, td { text-align: left; padding: 3px 10px; border-top: 1px solid #8884; vertical-align: top; }
td.number { text-align: right; white-space: nowrap; }
td.yes::before { content: "\\2713  "; } td.no { font-weight: 700; }
tr.failed { background: #d55e0033; } td.no::before { content: "\\2717  "; }
section { margin-top: 40px; border-top: 2px solid #8886; } .scroll { overflow-x: auto; }
img { max-width: 100%; height: auto; margin: 10px 0; background: #fff; }
.soft { opacity: .75; font-size: 13px; } pre { overflow-x: auto; font-size: 12px; }
"""


def html(summary: Mapping[str, Any]) -> str:
    """The page of `reproduce_all`'s summary; it needs no other files."""
    results = summary["figures"]
    parts = [_head(summary), _failing(summary["failing"]), _contents(results)]
    parts += [_figure(result) for result in results]
    return document("Figures and tables of the papers", parts)


#: A page loads nothing and sends nothing.
_POLICY = "default-src 'none'; img-src data:; style-src 'unsafe-inline'; script-src 'unsafe-inline'"


def document(
    title: str, parts: Iterable[str], *, style: str = _STYLE, script: str = "", data: str = ""
) -> str:
    """A page with a title, which needs no other files; the script finds the JSON in `#data`."""
    lines = [
        "<!doctype html><html lang='en'><head><meta charset='utf-8'>",
        "<meta name='viewport' content='width=device-width, initial-scale=1'>",
        f'<meta http-equiv="Content-Security-Policy" content="{_POLICY}">',
        f"<title>{title}</title><link rel='icon' href='data:,'><style>{style}</style></head>",
        f"<body><main><h1>{title}</h1>",
        *parts,
        "</main>",
    ]
    if script:
        lines.append(f'<script id="data" type="application/json">{data}</script>')
        lines.append(f"<script>\n{script}</script>")
    return "\n".join([*lines, "</body></html>"])


def _head(summary: Mapping[str, Any]) -> str:
    bands, results = summary["bands"], summary["figures"]
    errors = sum("error" in result for result in results)
    words = [f"{len(results)} figures and tables"]
    words.append(f"{bands['hold']} of {bands['all']} bands hold, {bands['fail']} do not")
    words += [f"{errors} figures ended with an error"] if errors else []
    words.append(f"{summary['seconds'] / 60:.1f} minutes")
    kinds = {"quick" if result["quick"] else "full" for result in results}
    sizes = " and ".join(sorted(kinds))
    return f"<p id='head'>{_text('; '.join(words))} ({_text(sizes)} sizes).</p>"


def _failing(rows: list[dict[str, Any]]) -> str:
    if not rows:
        return "<p id='failing'>Everything that has a band holds it.</p>"
    lines = [
        f"<tr class='failed'><td>{_link(row['figure'])}</td>"
        + (f"<td colspan='8'>{_text(row['error'])}</td>" if "error" in row else _cells(row))
        + "</tr>"
        for row in rows
    ]
    head = "<h2>What does not hold</h2><div class='scroll'><table id='failing'>"
    return head + _heading("figure") + "".join(lines) + "</table></div>"


def _contents(results: Iterable[Mapping[str, Any]]) -> str:
    lines = []
    for result in results:
        name, banded = result["figure"], [r for r in result["rows"] if r["holds"] is not None]
        held = sum(row["holds"] for row in banded)
        state = "error" if "error" in result else f"{held} of {len(banded)}" if banded else ""
        kind = "yes" if result["holds"] else "no"
        claim = "" if "error" in result else claim_of(result)
        lines.append(
            f"<tr><td>{_link(name)}</td><td>{_text(_description(name))}</td>"
            f"<td>{_text(claim)}</td><td class='{kind}'>{_text(state)}</td>"
            f"<td class='number'>{result.get('seconds', 0.0):.0f} s</td></tr>"
        )
    names = ("figure", "shows", "the paper's claim", "bands that hold", "took")
    head = f"<tr>{''.join(f'<th>{name}</th>' for name in names)}</tr>"
    return f"<h2>All of them</h2><table id='contents'>{head}{''.join(lines)}</table>"


def _figure(result: Mapping[str, Any]) -> str:
    name = result["figure"]
    rows = "".join(
        f"<tr class='{'failed' if row['holds'] is False else ''}'>{_cells(row)}</tr>"
        for row in result["rows"]
    )
    parts = [f"<section id='{_text(name)}'><h2>{_text(name)}: {_text(_description(name))}</h2>"]
    if "error" in result:
        parts.append(f"<pre>{_text(result.get('traceback', result['error']))}</pre>")
    else:
        said = sentence(result["rows"], quick=result["quick"], figure=result["figure"])
        parts.append(f"<p>{_text(said)}</p>")
    if rows:
        parts.append(f"<div class='scroll'><table>{_heading()}{rows}</table></div>")
    for file in result["files"]:
        if file.endswith(".png"):
            parts.append(f"<img alt='{_text(Path(file).stem)}' src='{_picture(file)}'>")
    parts += [f"<p>{_text(note)}</p>" for note in result["notes"]]
    parts += [
        f"<p>Left out: {_text(left['what'])}: {_text(left['reason'])}</p>"
        for left in result["skipped"]
    ]
    made = ", ".join(f"{k} {v}" for k, v in result["provenance"].items())
    parts.append(f"<p class='soft'>{_text(made)}</p></section>")
    return "".join(parts)


def _heading(first: str = "") -> str:
    names = [first] if first else []
    names += ["what", "printed", "measured", "ratio", "band", "holds", "claim", "note"]
    return f"<tr>{''.join(f'<th>{name}</th>' for name in names)}</tr>"


def _cells(row: Mapping[str, Any]) -> str:
    band = " … ".join(_number(end, i) for i, end in enumerate(row["band"] or ()))
    numbers = (_number(row["printed"]), _number(row["measured"]), _number(row["ratio"]), band)
    holds = {None: "<td></td>", True: "<td class='yes'>yes</td>", False: "<td class='no'>no</td>"}
    return (
        f"<td>{_text(row['what'])}</td>"
        + "".join(f"<td class='number'>{_text(number)}</td>" for number in numbers)
        + holds[row["holds"]]
        + f"<td>{_text(_claim(row))}</td>"
        + f"<td>{_text(row['note'])}</td>"
    )


def _claim(row: Mapping[str, Any]) -> str:
    """The verdict on the row's claim, and where it is found."""
    if row.get("found") is None:
        return ""
    low, high = row["claim"]
    where = interval(low, math.inf if high is None else high)
    verdict = "found" if row["found"] else "not found"
    return f"{verdict}: {where}" + (f" ({row['rule']})" if row.get("rule") else "")


def _number(value: Any, end: int | None = None) -> str:
    """A number with four digits; an open end of a band is infinite."""
    if value is None or value in (math.inf, -math.inf):
        return {None: "", 0: "−∞", 1: "∞"}[end]
    return value if isinstance(value, str) else f"{value:.4g}"


def _description(name: str) -> str:
    info = FIGURES.get(name)
    return "" if info is None else info.description


def _link(name: str) -> str:
    return f"<a href='#{_text(name)}'>{_text(name)}</a>"


def _picture(file: str) -> str:
    path = Path(file)
    return _encoded(file, path.stat().st_mtime_ns) if path.is_file() else ""


@lru_cache(maxsize=512)
def _encoded(file: str, changed: int) -> str:
    """The picture as a data URL; `changed` distinguishes versions of a file."""
    data = Path(file).read_bytes()
    kind = "png"
    if len(data) > LARGE_BYTES:
        from PIL import Image

        with Image.open(io.BytesIO(data)) as picture:
            shown = picture.convert("RGB")
            shown.thumbnail((WIDTH_PX, 4 * WIDTH_PX))
            smaller = io.BytesIO()
            shown.save(smaller, "WEBP", quality=92)
        data, kind = smaller.getvalue(), "webp"
    return f"data:image/{kind};base64,{base64.b64encode(data).decode('ascii')}"


def _text(value: Any) -> str:
    return _html.escape(str(value), quote=True)

"""The list of figures and tables, and reproducing one of them."""

from __future__ import annotations

import inspect
import json
import os
import re
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeAlias

from viscache.base import provenance
from viscache.base.files import finite, named, write_whole
from viscache.settings.checks import require
from viscache.settings.spelling import nearest
from viscache_lab.figures import references
from viscache_lab.figures.outcome import Outcome, text
from viscache_lab.figures.verdict import sentence, verdicts

__all__ = ["FIGURES", "FigureInfo", "code_hash", "figure", "reproduce"]

#: Arguments: the folder, `quick`, whether to show progress, and `size=` for sized figures.
Figure: TypeAlias = Callable[..., Outcome]


@dataclass(frozen=True, kw_only=True, slots=True)
class FigureInfo:
    """One figure or table of a paper, or an additional one."""

    description: str
    function: Figure
    sized: bool = False
    """Whether its pictures can have another size."""


#: Name to figure, in the order of the papers: figures and tables by number, then the others.
FIGURES: dict[str, FigureInfo] = {}
#: The papers; the trade of all methods and their extremes, which no paper has.
PAPERS = ("aqvc", "vlf", "vismap", "trade", "extremes")


def code_hash() -> str:
    """Hash of the code that determines a figure: the sources of viscache, its core, and the lab."""
    return provenance.code_hash(Path(__file__).parents[1])


def figure(name: str, description: str) -> Callable[[Figure], Figure]:
    """Register a function as `PAPER-NAME` or `trade`; it is sized if it takes `size`."""
    require(name.partition("-")[0] in PAPERS, f"a figure's paper must be one of {PAPERS}", name)
    require(name not in FIGURES, "a figure's name must be its own", name)

    def register(function: Figure) -> Figure:
        sized = "size" in inspect.signature(function).parameters
        FIGURES[name] = FigureInfo(description=description, function=function, sized=sized)
        return function

    return register


def arrange() -> None:
    """Sort `FIGURES`, independently of the order of imports."""

    def place(item: tuple[str, FigureInfo]) -> tuple[int, int, int, str]:
        paper, _, rest = item[0].partition("-")
        numbered = re.fullmatch(r"(fig|tab)(\d+)", rest)
        kind = ("fig", "tab").index(numbered[1]) if numbered else 2
        return PAPERS.index(paper), kind, int(numbered[2]) if numbered else 0, rest

    ordered = sorted(FIGURES.items(), key=place)
    FIGURES.clear()
    FIGURES.update(ordered)


def reproduce(
    name: str,
    directory: str | os.PathLike[str],
    *,
    quick: bool = False,
    progress: bool = False,
    size: tuple[int, int] | None = None,
) -> dict[str, Any]:
    """Reproduce one figure or table of the papers.

    Parameters
    ----------
    name : str
        One of `FIGURES`.
    directory : path
        Created if missing. Receives the pictures, `NAME.md` with the table, and `NAME.json`.
    quick : bool
        Small sizes: seconds instead of minutes.
    progress : bool
        Show a progress bar.
    size : (width, height), optional
        Size of the rendered pictures in pixels, for the figures that allow it.

    Returns
    -------
    dict
        What `viscache reproduce NAME --json` prints: figure, rows (what, printed, measured, ratio,
        band, holds, claim, rule, because, said, found, note), files; beside them holds, verdicts
        (claim and expectation, each with verdict, yes, all), skipped, notes, quick, provenance.

    Raises
    ------
    ValueError
        The name is unknown; the message gives the nearest known one. Or a size has no effect.
    """
    if name not in FIGURES:
        raise ValueError(f"unknown figure {name!r}{nearest(name, FIGURES)}")
    if size is not None and not FIGURES[name].sized:
        sized = ", ".join(n for n, info in FIGURES.items() if info.sized)
        raise ValueError(f"size must be left out for {name}; it is for {sized}")
    folder = Path(directory)
    folder.mkdir(parents=True, exist_ok=True)
    given = {} if size is None else {"size": size}
    began, cpu = time.perf_counter(), time.process_time()
    try:
        with references.kept_in(folder / "references"):
            outcome = FIGURES[name].function(folder, quick, progress, **given)
    except OSError as error:
        if error.filename is not None:
            raise
        raise named(error, folder) from error
    seconds, cpu = time.perf_counter() - began, time.process_time() - cpu
    table, record = folder / f"{name}.md", folder / f"{name}.json"
    rows = [row.as_dict() for row in outcome.rows]
    write_whole(table, f"{text(name, outcome.rows)}\n{sentence(rows, quick=quick, figure=name)}\n")
    result = {
        "figure": name,
        "rows": rows,
        "files": [str(path) for path in [*outcome.files, table, record]],
        "holds": all(row.holds is not False for row in outcome.rows),
        "verdicts": verdicts(rows, quick=quick, figure=name),
        "skipped": outcome.skipped,
        "notes": outcome.notes,
        "quick": quick,
        "size": None if size is None else list(size),
        "provenance": provenance.provenance(),
        "code": code_hash(),
        "seconds": seconds,
        "cpu_s": cpu,
    }
    write_whole(record, json.dumps(finite(result), indent=2))
    return result

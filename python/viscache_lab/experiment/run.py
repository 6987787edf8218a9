"""Runs experiments: a bench, a figure, or all figures in sequence, resumable, with their page."""

from __future__ import annotations

import errno
import json
import os
import time
import traceback
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from viscache.base import provenance
from viscache.base.files import finite, named, write_whole
from viscache_lab.experiment import page
from viscache_lab.experiment.amounts import machine
from viscache_lab.experiment.registry import BENCHES, FIGURES, Registry
from viscache_lab.experiment.rows import text
from viscache_lab.experiment.trial import Trial
from viscache_lab.experiment.verdict import claim_of, claims_not_found, sentence, verdicts

Result = dict[str, Any]
#: Errors of disks that are full or may not be written to.
NO_ROOM = (errno.ENOSPC, errno.EDQUOT, errno.EROFS, errno.EFBIG)


def code_hash() -> str:
    """Hash of the code that determines a figure: the sources of viscache, its core, and the lab."""
    return provenance.code_hash(Path(__file__).parents[1])


def run_bench(name: str, quick: bool = False, *, progress: bool = False, **options: Any) -> Result:
    """Run one of `BENCHES`: the object that `viscache bench NAME --json` prints.

    `options` are those of this bench alone. ValueError names the nearest bench to an unknown one.
    """
    trial = Trial(quick=quick, progress=progress, options=options)
    about = _perform(BENCHES, name, trial)
    return {
        "bench": name,
        "machine": machine(),
        "date": about["provenance"]["date"],
        "figures": trial.figures,
        "answers_checked": bool(trial.answers),
        "answers_hold": trial.answers_hold,
        "answers": trial.answers,
        "skipped": trial.skipped,
        "notes": trial.notes,
        "quick": quick,
    }


def _perform(registry: Registry, name: str, trial: Trial) -> Result:
    """Fill a trial; provenance and seconds of the run."""
    began, cpu = time.perf_counter(), time.process_time()
    registry.find(name).fill(trial)
    return {
        "provenance": provenance.provenance(),
        "seconds": time.perf_counter() - began,
        "cpu_s": time.process_time() - cpu,
    }


def reproduce(
    name: str,
    directory: str | os.PathLike[str],
    *,
    quick: bool = False,
    progress: bool = False,
    size: tuple[int, int] | None = None,
) -> Result:
    """Reproduce one of `FIGURES`: what `viscache reproduce NAME --json` prints.

    The directory, made if missing, gets the pictures, `NAME.md` with the table, and `NAME.json`.
    ValueError: the name is unknown, or the figure's pictures have no other size.
    """
    if not FIGURES.find(name).sized and size is not None:
        sized = ", ".join(n for n, info in FIGURES.items() if info.sized)
        raise ValueError(f"size must be left out for {name}; it is for {sized}")
    folder = Path(directory)
    folder.mkdir(parents=True, exist_ok=True)
    trial = Trial(folder=folder, quick=quick, progress=progress, size=size)
    try:
        about = _perform(FIGURES, name, trial)
    except OSError as error:
        if error.filename is not None:
            raise
        raise named(error, folder) from error
    table = folder / f"{name}.md"
    rows = [row.as_dict() for row in trial.rows]
    write_whole(table, f"{text(name, trial.rows)}\n{sentence(rows, quick=quick, figure=name)}\n")
    return _recorded(
        folder,
        figure=name,
        rows=rows,
        files=[str(path) for path in [*trial.files, table, folder / f"{name}.json"]],
        drawn=trial.drawn,
        holds=all(row.holds is not False for row in trial.rows),
        verdicts=verdicts(rows, quick=quick, figure=name),
        skipped=trial.skipped,
        notes=trial.notes,
        quick=quick,
        size=size,
        machine=machine(),
        **about,
    )


def _recorded(folder: Path, **found: Any) -> Result:
    """A figure's result, written into the folder; one that raised has nothing but its error."""
    nothing: Result = {"rows": [], "files": [], "drawn": {}, "skipped": [], "notes": []}
    result: Result = {**nothing, "holds": False, "verdicts": None, **found, "code": code_hash()}
    result["size"] = None if found["size"] is None else list(found["size"])
    write_whole(folder / f"{found['figure']}.json", json.dumps(finite(result), indent=2))
    return result


def reproduce_all(
    directory: str | os.PathLike[str],
    *,
    quick: bool = False,
    size: tuple[int, int] | None = None,
    progress: bool = False,
    older: bool = False,
    on_result: Callable[[Result, bool], None] | None = None,
) -> Result:
    """Reproduce all figures and tables; gives the object of `summary.json`.

    Results already in the directory are reused if code (unless `older`), `quick` and size are the
    same, so an interrupted run resumes with the next figure. A figure that raises is recorded with
    its error and does not hold. `index.html` and `summary.json` are rewritten after each figure;
    `on_result` gets each result and whether it was reused.
    """
    folder = Path(directory)
    folder.mkdir(parents=True, exist_ok=True)
    results: list[Result] = []
    for name, info in FIGURES.items():
        wanted = size if info.sized else None
        known = finished(folder, name, quick=quick, size=wanted, older=older)
        result = known or _reproduced(name, folder, quick=quick, size=wanted, progress=progress)
        results.append(result)
        if on_result is not None:
            on_result(result, known is not None)
        _write(folder, results)
    return _write(folder, results)


def finished(
    folder: Path, name: str, *, quick: bool, size: tuple[int, int] | None, older: bool = False
) -> Result | None:
    """A figure's result in the folder; None if incomplete or of other code, size or `quick`."""
    try:
        result: Result = json.loads((folder / f"{name}.json").read_text("utf-8"))
    except (FileNotFoundError, ValueError):
        return None
    same = result.get("quick") == quick and result.get("size") == (list(size) if size else None)
    of_code = older or result.get("code") == code_hash()
    there = all(Path(file).is_file() for file in result.get("files", []))
    return result if same and of_code and there and "error" not in result else None


def _reproduced(
    name: str, folder: Path, *, quick: bool, size: tuple[int, int] | None, progress: bool
) -> Result:
    began = time.perf_counter()
    try:
        return reproduce(name, folder, quick=quick, size=size, progress=progress)
    except Exception as error:
        if isinstance(error, OSError) and error.errno in NO_ROOM:
            raise  # the other figures would end in the same way
        return _recorded(
            folder,
            figure=name,
            quick=quick,
            size=size,
            provenance=provenance.provenance(),
            seconds=time.perf_counter() - began,
            error=f"{type(error).__name__}: {error}",
            traceback=traceback.format_exc(),
        )


def _write(folder: Path, results: list[Result]) -> Result:
    """Write the page and the summary of the results so far."""
    banded = [row for result in results for row in result["rows"] if row["holds"] is not None]
    missed = [row for row in banded if not row["holds"]]
    judged = [result for result in results if "error" not in result]
    claims = Counter(claim_of(result) for result in judged)
    summary: Result = {
        "figures": results,
        "page": str(folder / "index.html"),
        "holds": all(result["holds"] for result in results),
        "bands": {"all": len(banded), "hold": len(banded) - len(missed), "fail": len(missed)},
        "failing": list(failing(results)),
        "claims": {
            word.replace(" ", "_"): claims[word]
            for word in ("found", "not found", "not stated", "not judged")
        },
        "claims_not_found": claims_not_found(results),
        "seconds": sum(result.get("seconds", 0.0) for result in results),
    }
    write_whole(folder / "summary.json", json.dumps(finite(summary), indent=2))
    write_whole(folder / "index.html", page.html(summary))
    return summary


def failing(results: list[Result]) -> Iterator[dict[str, Any]]:
    """Rows that do not hold: figure, what, printed, measured, band; error if a figure raised."""
    for result in results:
        if "error" in result:
            yield {"figure": result["figure"], "error": result["error"]}
        for row in result["rows"]:
            if row["holds"] is False:
                yield {"figure": result["figure"], **row}

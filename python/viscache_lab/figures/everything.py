"""Makes all figures and tables in sequence, resumable, and one page with all of them."""

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

from viscache.base.files import finite, write_whole
from viscache.base.provenance import provenance
from viscache_lab.figures import page, registry
from viscache_lab.figures.registry import code_hash
from viscache_lab.figures.verdict import claim_of, claims_not_found

__all__ = ["failing", "finished", "reproduce_all"]

Result = dict[str, Any]
#: Errors of disks that are full or may not be written to.
NO_ROOM = (errno.ENOSPC, errno.EDQUOT, errno.EROFS, errno.EFBIG)


def reproduce_all(
    directory: str | os.PathLike[str],
    *,
    quick: bool = False,
    size: tuple[int, int] | None = None,
    progress: bool = False,
    older: bool = False,
    on_result: Callable[[Result, bool], None] | None = None,
) -> Result:
    """Reproduce all figures and tables.

    Results already in the directory are reused if code, `quick` and size are the same, so an
    interrupted run resumes with the next figure. A figure that raises is recorded with its error
    and does not hold. `index.html` and `summary.json` are rewritten after each figure.

    Parameters
    ----------
    directory : path
        Created if missing.
    quick : bool
        Small sizes: each figure takes seconds instead of minutes.
    size : (width, height), optional
        Size of pictures, for the figures that allow it.
    progress : bool
        Show progress bars.
    older : bool
        Also take results of other versions of the code.
    on_result : callable, optional
        Called with each result and whether it was reused.

    Returns
    -------
    dict
        figures (list of results; verdicts are None for one that raised), page, holds, bands (how
        many there are, hold and do not), failing (the rows that do not hold and the figures that
        raised), claims (in how many figures they are found, not_found, not_stated and, where runs
        are quick, not_judged),
        claims_not_found (the rows outside the paper's claim), seconds.
    """
    folder = Path(directory)
    folder.mkdir(parents=True, exist_ok=True)
    results: list[Result] = []
    for name, info in registry.FIGURES.items():
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
        return registry.reproduce(name, folder, quick=quick, size=size, progress=progress)
    except Exception as error:
        if isinstance(error, OSError) and error.errno in NO_ROOM:
            raise  # the other figures would end in the same way
        result: Result = {
            "figure": name,
            "rows": [],
            "files": [],
            "holds": False,
            "verdicts": None,
            "skipped": [],
            "notes": [],
            "quick": quick,
            "size": None if size is None else list(size),
            "provenance": provenance(),
            "code": code_hash(),
            "seconds": time.perf_counter() - began,
            "error": f"{type(error).__name__}: {error}",
            "traceback": traceback.format_exc(),
        }
        write_whole(folder / f"{name}.json", json.dumps(finite(result), indent=2))
        return result


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

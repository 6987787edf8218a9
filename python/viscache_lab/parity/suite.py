"""The parity suite: the zoo and the shared scenes, their verdicts, and the page."""

from __future__ import annotations

import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from fnmatch import fnmatchcase
from pathlib import Path

from viscache.base.progress import Progress, progress_bar
from viscache.base.provenance import VERSION
from viscache_lab.parity import zoo
from viscache_lab.parity.judge import FULL, QUICK, Judged, judge
from viscache_lab.parity.page import write_page
from viscache_lab.parity.renderers import mitsuba
from viscache_lab.parity.shared import Shared, shared_scenes


@dataclass(kw_only=True, slots=True)
class Suite:
    """What a run found."""

    results: list[Judged] = field(default_factory=list)
    skipped: list[Shared] = field(default_factory=list)
    page: Path | None = None
    seconds: float = 0.0

    @property
    def silent_misses(self) -> list[Judged]:
        """Scenes that differ without a warning, the worst first."""
        return sorted((r for r in self.results if r.silent_miss), key=_severity, reverse=True)


def run_suite(
    *,
    quick: bool = False,
    only: str = "*",
    output: Path | None = None,
    threads: int | None = None,
    progress: Progress = False,
) -> Suite:
    """Judge every scene whose name matches.

    Parameters
    ----------
    quick : bool
        Each feature once, with few samples.
    only : str
        A pattern of names, e.g. `material/*`.
    output : path, optional
        Folder for the page, `index.html`, and the scene files, `scenes/`.
    threads : int, optional
        All cores by default.
    progress : bool or callable
        As in `vc.render`.

    Raises
    ------
    ValueError
        No name matches.
    """
    begin = time.perf_counter()
    with _folder(output) as folder:
        paths, skipped = _files(folder, quick, only)
        suite = Suite(skipped=skipped)
        with mitsuba(threads) as mi, progress_bar(progress, "scene") as done:
            for i, (name, path) in enumerate(paths.items()):
                effort = QUICK if quick else FULL
                suite.results.append(judge(mi, name, path, effort=effort, threads=threads))
                if done is not None:
                    done(i + 1, len(paths))
            version = str(mi.__version__)
    suite.seconds = time.perf_counter() - begin
    if output is not None:
        suite.page = output / "index.html"
        write_page(suite.page, suite.results, _about(suite, version, quick))
    return suite


@contextmanager
def _folder(output: Path | None) -> Iterator[Path]:
    if output is not None:
        yield output / "scenes"
        return
    with tempfile.TemporaryDirectory(prefix="viscache-parity-") as made:
        yield Path(made)


def _files(folder: Path, quick: bool, only: str) -> tuple[dict[str, Path], list[Shared]]:
    """The files of all scenes that match, and the shared scenes that have none."""
    chosen = [case for case in zoo.cases(quick=quick) if fnmatchcase(case.name, only)]
    paths = zoo.write(folder, chosen)
    skipped = []
    for scene in shared_scenes(folder, only=only, quick=quick):
        if scene.path is None:
            skipped.append(scene)
        else:
            paths[scene.name] = scene.path
    if not paths and not skipped:
        kind = "quick scene" if quick else "scene"
        raise ValueError(f"no {kind} has a name like {only!r}; names are like 'material/*'")
    return paths, skipped


def _severity(result: Judged) -> float:
    """How much of the picture is wrong."""
    c = result.compared
    return 2.0 if c is None else 1 - c.share + min(abs(c.energy_difference), 1.0)


def _about(suite: Suite, version: str, quick: bool) -> dict[str, str]:
    every, misses = len(suite.results), len(suite.silent_misses)
    left_out = "; ".join(f"{s.name}: {s.reason}" for s in suite.skipped)
    rows = {
        "scenes": f"{every}, each with one feature of Mitsuba's XML, and shared ones",
        "silent": f"{misses} differ without a warning",
        "versions": f"viscache {VERSION}, Mitsuba {version} (scalar_rgb)",
        "suite": f"{'quick' if quick else 'full'}, {suite.seconds / 60:.1f} minutes",
    }
    return rows | ({"left out": left_out} if left_out else {})

"""Pictures of files against Mitsuba 3, or a formula: nothing may differ without a warning."""

from __future__ import annotations

import re
import statistics
import tempfile
import time
from collections import Counter, defaultdict
from contextlib import ExitStack
from fnmatch import fnmatchcase
from pathlib import Path

from viscache.base.progress import progress_bar
from viscache.base.provenance import VERSION
from viscache_lab.experiment import BENCHES, Trial
from viscache_lab.parity import exporters, renderers, zoo
from viscache_lab.parity.judge import FULL, QUICK, VERDICTS, Judged, judge
from viscache_lab.parity.page import write_page
from viscache_lab.parity.shared import shared_scenes


@BENCHES.add("parity", "pictures of a zoo of scene files and of shared scenes against Mitsuba 3")
def parity(trial: Trial) -> list[Judged]:
    """Judge every scene of the zoos and every shared one whose name matches.

    Options: `only`, a pattern of names, e.g. `material/*`; `output`, a folder for the page,
    `index.html`, and the scene files, `scenes/`; `threads`, all cores by default.
    """
    begin = time.perf_counter()
    output, threads = (trial.options.get(name) for name in ("output", "threads"))
    effort = QUICK if trial.quick else FULL
    version = ""
    results: list[Judged] = []
    with ExitStack() as stack:
        if output is None:
            made = tempfile.TemporaryDirectory(prefix="viscache-parity-")
            folder = Path(stack.enter_context(made))
        else:
            folder = output / "scenes"
        rows, paths = _files(trial, folder)
        done = stack.enter_context(progress_bar(trial.progress, "scene"))

        def add(result: Judged) -> None:
            results.append(result)
            if done is not None:
                done(len(results), len(rows) + len(paths))

        for row, path in rows:
            add(exporters.judge_row(row, path, threads=threads))
        if paths:
            mi = stack.enter_context(renderers.mitsuba(threads))
            version = f", Mitsuba {mi.__version__} (scalar_rgb)"
        for name, path in paths.items():
            add(judge(mi, name, path, effort=effort, threads=threads))
    seconds = time.perf_counter() - begin
    left_out = "; ".join(f"{left['what']}: {left['reason']}" for left in trial.skipped)
    record(trial, results, seconds)
    if output is not None:
        about = {
            "scenes": f"{len(results)}, each with one feature of a format, and shared ones",
            "silent": f"{sum(r.silent_miss for r in results)} differ without a warning",
            "versions": f"viscache {VERSION}{version}",
            "suite": f"{'quick' if trial.quick else 'full'}, {seconds / 60:.1f} minutes",
        }
        more = {"left out": left_out} if left_out else {}
        write_page(output / "index.html", results, about | more)
    return results


def _files(trial: Trial, folder: Path) -> tuple[list[tuple[exporters.Row, Path]], dict[str, Path]]:
    """The files of all scenes that match: those judged by formulas, and those that Mitsuba renders.

    Shared scenes that have no file are skipped, and all of the second kind without Mitsuba.
    """
    only = trial.options.get("only") or "*"
    rows = [row for row in exporters.rows(quick=trial.quick) if fnmatchcase(row.name, only)]
    written = exporters.write(folder, rows)
    chosen = [case for case in zoo.cases(quick=trial.quick) if fnmatchcase(case.name, only)]
    paths: dict[str, Path] = {}
    if reason := renderers.missing():
        trial.skip("parity", reason)
    else:
        paths = zoo.write(folder, chosen)
        for scene in shared_scenes(folder, only=only, quick=trial.quick):
            if scene.path is None:
                trial.skip(scene.name, scene.reason)
            else:
                paths[scene.name] = scene.path
    if not rows and not paths and not trial.skipped:
        kind = "quick scene" if trial.quick else "scene"
        raise ValueError(f"no {kind} has a name like {only!r}; names are like 'material/*'")
    return [(row, written[row.name]) for row in rows], paths


def record(trial: Trial, results: list[Judged], seconds: float) -> None:
    """Silent misses, the worst first; how many scenes have each verdict; why others have none."""
    misses = sorted((r for r in results if r.silent_miss), key=lambda r: -r.severity)
    trial.check("scenes that differ without a warning", len(misses), 0)
    for miss in misses:
        why = "; ".join(filter(None, (miss.why, miss.about)))
        trial.check(f"{miss.name}, {why}, differs without a warning", 1, 0)
    counts = Counter(r.verdict for r in results)
    for verdict in VERDICTS:
        if counts[verdict]:
            trial.at_most(f"scenes: {verdict}", counts[verdict], "scenes", None)
    found = [r.compared.power for r in results if r.compared and r.verdict == "agrees"]
    if found:
        power = 100 * statistics.median(found)
        trial.at_most("a block's difference that would be found", power, "%", None)
    trial.at_most("seconds", seconds, "s", None)
    reasons: dict[tuple[str, str], list[str]] = defaultdict(list)
    for result in results:
        # Places in files do not part reasons
        why = re.sub(r"^\S+\.\w+:(\d+:)? ", "", result.why)
        reasons[result.verdict, why].append(result.name)
    for verdict in ("warned", "warned though right", "not loaded", "not comparable"):
        for (of, why), names in reasons.items():
            if of == verdict:
                scenes = f"{len(names)} scenes, e.g. {names[0]}" if names[1:] else names[0]
                trial.skip(scenes, f"{verdict}: {why}")

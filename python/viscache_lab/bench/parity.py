"""Pictures of files against Mitsuba 3: nothing may differ without a warning."""

from __future__ import annotations

import statistics
from collections import defaultdict
from collections.abc import Iterable
from pathlib import Path

from viscache.base.progress import Progress
from viscache_lab.bench.common import Outcome, at_most_figure
from viscache_lab.parity import renderers
from viscache_lab.parity.judge import VERDICTS, Judged, Verdict
from viscache_lab.parity.suite import Suite, run_suite

__all__ = ["parity"]


def parity(
    quick: bool,
    *,
    only: str = "*",
    output: Path | None = None,
    threads: int | None = None,
    progress: Progress = False,
) -> Outcome:
    """Judge the zoo and the shared scenes; `output` is the folder of the page."""
    outcome = Outcome()
    if reason := renderers.missing():
        outcome.skip("parity", reason)
        return outcome
    suite = run_suite(quick=quick, only=only, output=output, threads=threads, progress=progress)
    misses = suite.silent_misses
    outcome.check("scenes that differ without a warning", len(misses), 0)
    for miss in misses:
        outcome.check(f"{miss.name}, {miss.why}, differs without a warning", 1, 0)
    outcome.figures = _figures(suite)
    for scene in suite.skipped:
        outcome.skip(scene.name, scene.reason)
    for verdict in ("warned", "not loaded", "not comparable"):
        for names, why in _by_reason(suite.results, verdict):
            outcome.skip(names, f"{verdict}: {why}")
    return outcome


def _figures(suite: Suite) -> list[dict[str, object]]:
    counts = {v: sum(r.verdict == v for r in suite.results) for v in VERDICTS}
    figures = [
        at_most_figure(f"scenes: {verdict}", count, "scenes", None)
        for verdict, count in counts.items()
        if count
    ]
    found = [r.compared.power for r in suite.results if r.compared and r.verdict == "agrees"]
    if found:
        power = 100 * statistics.median(found)
        figures.append(at_most_figure("a block's difference that would be found", power, "%", None))
    figures.append(at_most_figure("seconds", suite.seconds, "s", None))
    return figures


def _by_reason(results: Iterable[Judged], verdict: Verdict) -> list[tuple[str, str]]:
    """Names by reason; places in files do not part reasons."""
    names: dict[str, list[str]] = defaultdict(list)
    for result in results:
        if result.verdict == verdict:
            names[result.why.split(".xml:", 1)[-1].split(": ", 1)[-1]].append(result.name)
    return [(f"{len(n)} scenes, e.g. {n[0]}" if n[1:] else n[0], why) for why, n in names.items()]

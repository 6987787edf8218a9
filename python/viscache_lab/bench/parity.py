"""Pictures of files against Mitsuba 3: nothing may differ without a warning."""

from __future__ import annotations

import statistics
from collections import defaultdict
from collections.abc import Iterable

from viscache_lab.experiment import BENCHES, Trial
from viscache_lab.experiment.amounts import at_most_figure
from viscache_lab.parity import renderers
from viscache_lab.parity.judge import VERDICTS, Judged, Verdict
from viscache_lab.parity.suite import Suite, run_suite


@BENCHES.add("parity", "pictures of a zoo of scene files and of shared scenes against Mitsuba 3")
def parity(trial: Trial) -> None:
    """Judge the zoo and the shared scenes; options are those of `run_suite`."""
    if reason := renderers.missing():
        trial.skip("parity", reason)
        return
    suite = run_suite(quick=trial.quick, progress=trial.progress, **trial.options)
    misses = suite.silent_misses
    trial.check("scenes that differ without a warning", len(misses), 0)
    for miss in misses:
        trial.check(f"{miss.name}, {miss.why}, differs without a warning", 1, 0)
    trial.figures = _figures(suite)
    for scene in suite.skipped:
        trial.skip(scene.name, scene.reason)
    for verdict in ("warned", "not loaded", "not comparable"):
        for names, why in _by_reason(suite.results, verdict):
            trial.skip(names, f"{verdict}: {why}")


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

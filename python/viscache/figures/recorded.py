"""Claims of the papers as full runs found them; docs/claims.md lists all, docs/limits.md the rest.

The rest are those that were not found.
"""

from __future__ import annotations

from collections.abc import Iterable

from viscache.figures import recorded_aqvc, recorded_vismap, recorded_vlf
from viscache.figures.claim_rules import RULES, Claim
from viscache.figures.recorded_value import Missing, Recorded, Run, interval, words

__all__ = [
    "CLAIMING",
    "MISSING",
    "RECORDED",
    "RUNS",
    "claims",
    "not_recorded",
    "rules",
    "runs",
    "table",
]

RECORDED: tuple[Recorded, ...] = (
    *recorded_aqvc.RECORDED,
    *recorded_vlf.RECORDED,
    *recorded_vismap.RECORDED,
)
RUNS: tuple[Run, ...] = (*recorded_aqvc.RUNS, *recorded_vlf.RUNS, *recorded_vismap.RUNS)
MISSING: tuple[Missing, ...] = (
    *recorded_aqvc.MISSING,
    *recorded_vlf.MISSING,
    *recorded_vismap.MISSING,
)
#: Figures that judge a claim of a paper, if only in full runs.
CLAIMING = frozenset({one.figure for one in RECORDED} | {one.figure for one in MISSING})
FOUND = {True: "found", False: "not found"}


def table(recorded: Iterable[Recorded] = RECORDED) -> str:
    """The claims that were not found, as the Markdown table of docs/limits.md."""
    lines = [
        "| command | the paper | measured | found at | full run here |",
        "| --- | --- | --- | --- | --- |",
    ]
    for one in recorded:
        claim = one.band.claim
        if one.found is not False or claim is None:
            continue
        lines.append(
            f"| `viscache reproduce {one.figure}` | {one.said} | {one.what} | {interval(*claim)} "
            f"| {one.link} |"
        )
    return "\n".join(lines) + "\n"


def claims(paper: str, recorded: Iterable[Recorded] = RECORDED) -> str:
    """All recorded claims of a paper, as a Markdown table of docs/claims.md."""
    lines = [
        "| figure | the paper | rule | row | found at | full run here | verdict |",
        "| --- | --- | --- | --- | --- | --- | --- |",
    ]
    for one in recorded:
        claimed = one.band.claimed
        if not one.figure.startswith(f"{paper}-") or claimed is None or one.found is None:
            continue
        lines.append(
            f"| `{one.figure}` | {one.said} | {_rule(claimed)} | {one.what} "
            f"| {interval(claimed.low, claimed.high)} | {one.link} | {FOUND[one.found]} |"
        )
    return "\n".join(lines) + "\n"


def not_recorded(missing: Iterable[Missing] = MISSING) -> str:
    """The claims without a recorded run, as the Markdown table of docs/claims.md."""
    lines = ["| figure | the paper | rule | found at | why |", "| --- | --- | --- | --- | --- |"]
    for one in missing:
        claimed = one.band.claimed
        if claimed is not None:
            lines.append(
                f"| `{one.figure}` | {words(one.band)} | {_rule(claimed)} "
                f"| {interval(claimed.low, claimed.high)} | {one.reason} |"
            )
    return "\n".join(lines) + "\n"


def rules() -> str:
    """The rules, as the Markdown table of docs/claims.md."""
    lines = [f"| `{rule}` | {says} |" for rule, says in RULES.items()]
    return "\n".join(["| rule | found at |", "| --- | --- |", *lines]) + "\n"


def runs(known: Iterable[Run] = RUNS) -> str:
    """The runs, as the Markdown table of docs/claims.md."""
    lines = [
        f"| `viscache reproduce {one.figure}` | {one.date} | {one.machine} | {one.frame} |"
        for one in known
    ]
    head = ["| command | date | machine | frame |", "| --- | --- | --- | --- |"]
    return "\n".join([*head, *lines]) + "\n"


def _rule(claimed: Claim) -> str:
    """The rule's name, with the reason of a limit for words."""
    return f"`{claimed.rule}`" + (f": {claimed.because}" if claimed.because else "")

"""The tables of the documentation that come from the last full runs."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import groupby

from viscache_lab.experiment.claim_rules import RULES, interval
from viscache_lab.experiment.full_run import RUNS, FullRun, Judged

Runs = Mapping[str, FullRun]
#: Rows of a claim that are named one by one; more are counted.
NAMED = 2


def rules() -> str:
    """The rules of docs/claims.md."""
    return _table("rule, found at", ([f"`{rule}`", says] for rule, says in RULES.items()))


def times(runs: Runs) -> str:
    """When and how long each figure ran, and how many bands held."""
    lines = [
        [
            *(f"`viscache reproduce {name}`", run.date, run.machine),
            *(f"{run.seconds / 60:.1f}", f"{run.cpu_s / 60:.1f}"),
            _share(run.bands - len(run.failing), run.bands) or "–",
        ]
        for name, run in runs.items()
    ]
    minutes, cpu = (sum(getattr(r, a) for r in runs.values()) / 60 for a in ("seconds", "cpu_s"))
    bands = sum(run.bands for run in runs.values())
    held = bands - sum(len(run.failing) for run in runs.values())
    whole = [f"all {len(runs)}", "", "", f"{minutes:.0f}", f"{cpu:.0f}", _share(held, bands)]
    heads = "command, date, machine, minutes, CPU minutes, bands that hold"
    return _table(heads, [*lines, whole])


def failing(runs: Runs) -> str:
    """The bands that do not hold."""
    rows = [(f"`viscache reproduce {name}`", r) for name, run in runs.items() for r in run.failing]
    lines = ([n, r.what, _number(r.measured), interval(r.low, r.high)] for n, r in rows)
    return _table("command, row, measured, band", lines)


def claims(paper: str, runs: Runs) -> str:
    """All claims of a paper: those of docs/claims.md."""
    lines = []
    for name, rows in _judged(runs):
        if name.startswith(f"{paper}-"):
            one, found = rows[0], sum(row.found for row in rows)
            rule = f"`{one.rule}`" + (f": {one.because}" if one.because else "")
            verdict = {0: "not found", len(rows): "found"}.get(found)
            verdict = verdict or f"found in {_share(found, len(rows))}"
            at = [interval(one.low, one.high), _values(rows), verdict]
            lines.append([f"`{name}`", one.said, rule, _what(rows), *at])
    return _table("figure, the paper, rule, row, found at, full run here, verdict", lines)


def not_found(runs: Runs) -> str:
    """The rows outside the papers' claims: those of docs/limits.md."""
    lines = []
    for name, rows in _judged(runs):
        missed = [row for row in rows if not row.found]
        if missed:
            of = "" if len(missed) == len(rows) else f" (others: {len(rows) - len(missed)} found)"
            at = [interval(rows[0].low, rows[0].high), _values(missed)]
            command = f"`viscache reproduce {name}`"
            lines.append([command, rows[0].said, f"{_what(missed)}{of}", *at])
    return _table("command, the paper, measured, found at, full run here", lines)


def _table(heads: str, rows: Iterable[Sequence[str]]) -> str:
    """A Markdown table; the heads are parted by commas."""
    names = heads.split(", ")
    lines = [names, ["---"] * len(names), *rows]
    return "".join("|" + "".join(f" {c} |" if c else " |" for c in line) + "\n" for line in lines)


def _judged(runs: Runs) -> Iterator[tuple[str, list[Judged]]]:
    """Figure and rows of each claim, in the order in which the claims come up."""
    for name, run in runs.items():
        order = {claim: n for n, claim in enumerate(dict.fromkeys(r.claim for r in run.judged))}
        rows = sorted(run.judged, key=lambda row: order[row.claim])
        for _, same in groupby(rows, key=lambda row: row.claim):
            yield name, list(same)


def _what(rows: list[Judged]) -> str:
    names = "; ".join(row.what for row in rows)
    return names if len(rows) <= NAMED else f"{len(rows)} rows"


def _values(rows: list[Judged]) -> str:
    if len(rows) <= NAMED:
        return "; ".join(_number(row.measured) for row in rows)
    known = [row.measured for row in rows if row.measured is not None]
    ends = dict.fromkeys(_number(end(known)) for end in (min, max)) if known else ["–"]
    return " to ".join(ends)


def _number(value: float | None) -> str:
    if value is None:
        return "–"
    return f"{value:.0f}" if value == round(value) and abs(value) < 1e6 else f"{value:.4g}"


def _share(part: int, of: int) -> str:
    return f"{part} of {of}" if of else ""


#: Page to the tables between its comments `<!-- name -->` and `<!-- end of name -->`.
PAGES: dict[str, dict[str, str]] = {
    "docs/claims.md": {
        "rules": rules(),
        "aqvc": claims("aqvc", RUNS),
        "vlf": claims("vlf", RUNS),
        "vismap": claims("vismap", RUNS),
    },
    "docs/limits.md": {"claims not found": not_found(RUNS)},
    "docs/performance/sweeps.md": {"full runs": times(RUNS), "failing bands": failing(RUNS)},
}


def filled(page: str, text: str) -> str:
    """The page's text with its tables as they must be; ValueError if it lacks their comments."""
    for name, table in PAGES[page].items():
        begin, end = f"<!-- {name} -->\n", f"<!-- end of {name} -->"
        if begin not in text or end not in text:
            raise ValueError(f"{page} must have the comments of {name!r}")
        before, _, rest = text.partition(begin)
        text = before + begin + table + end + rest.partition(end)[2]
    return text

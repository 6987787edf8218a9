"""docs/claims.md and docs/limits.md list the claims of the papers as full runs found them."""

from __future__ import annotations

import math
import re
from dataclasses import replace

import pytest

from codebase.repository import text
from figures.every_band import all_bands
from viscache.figures import FIGURES, aqvc_bands, vismap_bands, vlf_bands
from viscache.figures.claims_pages import PAGES, filled
from viscache.figures.outcome import Band
from viscache.figures.recorded import MISSING, RECORDED, RUNS, claims, not_recorded, runs, table
from viscache.figures.recorded_value import Recorded, interval

RECORDS = {f"{one.figure}: {one.what}": one for one in RECORDED}
FLICKER = next(one for one in RECORDED if one.what.startswith("H8"))


def section(page: str, heading: str) -> str:
    """The text under a heading, up to the next one of its level or above."""
    lines = text(f"docs/{page}").splitlines()
    (start,) = [n for n, line in enumerate(lines) if re.fullmatch(f"#+ {heading}", line)]
    level = lines[start].index(" ")
    after = lines[start + 1 :]
    ends = [n for n, line in enumerate(after) if re.match(f"#{{1,{level}}} ", line)]
    return "\n".join(after[: ends[0]] if ends else after)


def stands(one: Recorded) -> bool:
    """Whether its page holds the value."""
    return bool(
        re.search(rf"(?<![\d.]){re.escape(one.written)}(?![\d])", section(one.page, one.section))
    )


@pytest.mark.parametrize("page", PAGES)
def test_pages_list_what_is_recorded(page: str) -> None:
    """After a change: scripts/claims_pages.py."""
    assert filled(page, text(page)) == text(page)
    changed = text(page).replace("| found |", "| lost |").replace("0.54", "0.45")
    assert filled(page, changed) == text(page) != changed
    with pytest.raises(ValueError, match="must have the comments"):
        filled(page, "")


@pytest.mark.parametrize("what", RECORDS)
def test_a_recorded_value_judges_a_claim_and_has_a_dated_run(what: str) -> None:
    one = RECORDS[what]
    assert one.figure in FIGURES and one.band.claim is not None and one.found is not None
    (run,) = [run for run in RUNS if run.figure == one.figure]
    assert re.fullmatch(r"2026-\d\d-\d\d", run.date) and run.machine in "ABC" and run.frame


@pytest.mark.parametrize("what", [what for what, one in RECORDS.items() if one.page])
def test_a_recorded_value_is_the_one_of_its_page(what: str) -> None:
    assert stands(RECORDS[what])


def claiming() -> dict[str, Band]:
    """Bands of full runs that state a claim."""
    found: dict[str, Band] = {}
    for bands in (aqvc_bands, vlf_bands, vismap_bands):
        found |= {f"{bands.__name__}.{name}": band for name, band in all_bands(bands).items()}
    return {n: b for n, b in found.items() if b.claim is not None and ".QUICK_" not in n}


def test_every_claim_is_recorded_or_listed_with_the_reason() -> None:
    recorded = {id(one.band) for one in RECORDED}
    missing = {id(one.band) for one in MISSING}
    judged = claiming()
    assert [name for name, band in judged.items() if id(band) not in recorded | missing] == []
    assert not recorded & missing and len(recorded) >= 30
    assert recorded | missing <= {id(band) for band in judged.values()}
    assert all(one.figure in FIGURES and one.reason for one in MISSING)


def test_each_recorded_figure_has_one_run_and_each_run_a_value() -> None:
    assert len({run.figure for run in RUNS}) == len(RUNS)
    assert {run.figure for run in RUNS} == {one.figure for one in RECORDED}


def test_the_tables_say_what_was_recorded() -> None:
    rows = claims("aqvc", [FLICKER]).splitlines()
    assert len(rows) == 3 and rows[2].endswith("#claims) | not found |")
    assert "`nearly_none`" in rows[2] and "≤ 0.1" in rows[2]
    better = claims("aqvc", [replace(FLICKER, written="0.05")]).splitlines()
    assert better[2].endswith("| found |")
    assert claims("vlf", [FLICKER]).count("\n") == 2
    assert MISSING[0].reason in not_recorded(MISSING[:1])
    assert RUNS[0].date in runs(RUNS[:1])


def test_an_interval_is_written_in_words() -> None:
    assert interval(2.0, 2.0) == "2" and interval(51_208, 51_208) == "51208"
    assert interval(1.45, math.inf) == "≥ 1.45" and interval(0.0, 0.489) == "≤ 0.489"
    assert interval(-1.0, -0.99) == "-1 to -0.99"


def test_a_value_that_its_page_does_not_hold_is_noticed() -> None:
    assert not stands(replace(FLICKER, written="0.53"))
    assert not stands(replace(FLICKER, written=".54"))
    assert not stands(replace(FLICKER, section="Figure 7"))


def test_only_what_was_not_found_is_listed() -> None:
    assert FLICKER.found is False and "| ≤ 0.1 | [0.54](" in table([FLICKER])
    better = replace(FLICKER, written="0.05")
    assert better.found and "0.05" not in table([better])
    assert replace(FLICKER, written="9 %").measured == 0.09
    listed = table().count("`viscache reproduce ")
    assert listed == sum(one.found is False for one in RECORDED) >= 7

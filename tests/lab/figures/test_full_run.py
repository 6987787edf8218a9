"""The pages list times, bands and claims of the last full runs as `full_run.json` keeps them."""

import datetime
import math
import re
from dataclasses import replace

import pytest

from codebase.repository import text
from lab.figures.test_bands import EVERY
from viscache_lab.experiment import Band, Row, claims_pages
from viscache_lab.experiment.claim_rules import Claim, interval
from viscache_lab.experiment.claims_pages import PAGES, filled
from viscache_lab.experiment.full_run import RUNS, kept, read, written
from viscache_lab.figures import FIGURES
from viscache_lab.figures.bands import aqvc

#: A claim that no full run here found, so far.
FLICKER = next(row for row in RUNS["aqvc-claims"].judged if row.what.startswith("H8"))


def claim_of(band):
    one = band.claimed
    return band.said, one.rule, one.because, one.low, one.high


@pytest.mark.parametrize("page", PAGES)
def test_pages_list_the_last_full_runs(page):
    """After a change: scripts/claims_pages.py."""
    assert filled(page, text(page)) == text(page)
    changed = text(page).replace("`viscache reproduce aqvc-fig", "`").replace("| found |", "| |")
    assert changed != text(page) and filled(page, changed) == text(page)
    with pytest.raises(ValueError, match="must have the comments"):
        filled(page, "")


def test_every_figure_has_a_full_run_in_order():
    assert list(RUNS) == list(FIGURES)
    method = text("docs/performance/method.md")
    for run in RUNS.values():
        assert datetime.date.fromisoformat(run.date) <= datetime.date.today()
        assert f"| **{run.machine}** |" in method and run.seconds > 0 and run.cpu_s > 0
        assert len(run.failing) <= run.bands


def test_every_claim_is_judged_by_a_full_run():
    judged = {row.claim for run in RUNS.values() for row in run.judged}
    of_full_runs = {n: b for n, b in EVERY.items() if b.claim is not None and ".QUICK_" not in n}
    declared = {name: claim_of(band) for name, band in of_full_runs.items()}
    assert [name for name, claim in declared.items() if claim not in judged] == []
    assert judged <= set(declared.values())
    assert FLICKER.claim == claim_of(aqvc.H8_FLICKER)


@pytest.mark.parametrize("name", [name for name, run in RUNS.items() if run.judged])
def test_the_frame_of_each_claim_is_listed(name):
    assert re.search(rf"^\| `{name}` \| [^|`]+ \|$", text("docs/claims.md"), re.MULTILINE)


def result(*rows, **others):
    """A figure's result, as `figures.reproduce` returns it."""
    made = {"figure": "aqvc-claims", "quick": False, "size": None, "seconds": 6.04, "cpu_s": 10.0}
    made |= {
        "rows": [r.as_dict() for r in rows],
        "provenance": {"date": "2026-11-26T20:01:06+00:00"},
    }
    return made | others


WIDE = Band(0.5, math.inf, "Fig. 1: more; expected: much", claimed=Claim.by("more"))


def test_a_run_is_kept_with_its_bands_and_claims():
    run = kept(result(Row("a", 0.7, band=WIDE), Row("b", 0.4, band=WIDE), Row("c", 2.0)), "C")
    assert (run.date, run.machine, run.seconds, run.bands) == ("2026-11-26", "C", 6.0, 2)
    assert [row.what for row in run.failing] == ["b"]
    judged = [(row.what, row.said, row.found) for row in run.judged]
    assert judged == [(name, "Fig. 1: more", False) for name in "ab"]
    assert read(written({"aqvc-claims": run})) == {"aqvc-claims": run}


@pytest.mark.parametrize("fault", [{"quick": True}, {"size": [32, 32]}, {"error": "too hot"}])
def test_only_full_runs_are_kept(fault):
    with pytest.raises(ValueError, match=r"must be full.*aqvc-claims is not"):
        kept(result(Row("a", 1.0), **fault), "C")


def run_of(*judged):
    return {"aqvc-claims": replace(RUNS["aqvc-claims"], judged=judged)}


def test_a_claim_of_one_row_has_a_verdict_and_its_value():
    (row,) = claims_pages.claims("aqvc", run_of(replace(FLICKER, measured=0.54))).splitlines()[2:]
    assert row.endswith("| ≤ 0.1 | 0.54 | not found |") and "`nearly_none`" in row
    (row,) = claims_pages.claims("aqvc", run_of(replace(FLICKER, measured=0.05))).splitlines()[2:]
    assert row.endswith("| ≤ 0.1 | 0.05 | found |")
    assert claims_pages.claims("vlf", run_of(FLICKER)).count("\n") == 2


def test_a_claim_of_many_rows_has_their_range():
    rows = [replace(FLICKER, what=f"row {n}", measured=0.05 * n) for n in range(4)]
    (row,) = claims_pages.claims("aqvc", run_of(*rows)).splitlines()[2:]
    assert "| 4 rows | ≤ 0.1 | 0 to 0.15 | found in 3 of 4 |" in row
    (row,) = claims_pages.not_found(run_of(*rows)).splitlines()[2:]
    assert "| row 3 (others: 3 found) | ≤ 0.1 | 0.15 |" in row
    assert claims_pages.not_found(run_of(*rows[:3])).count("\n") == 2


def test_an_unmeasured_row_is_not_found():
    unmeasured = replace(FLICKER, measured=None)
    (row,) = claims_pages.not_found(run_of(unmeasured)).splitlines()[2:]
    assert row.endswith("| ≤ 0.1 | – |") and not unmeasured.found


def test_bands_that_do_not_hold_are_listed():
    run = kept(result(Row("b", 0.4, band=WIDE), Row("a", 0.7, band=WIDE)), "C")
    (row,) = claims_pages.failing({"aqvc-claims": run}).splitlines()[2:]
    assert row == "| `viscache reproduce aqvc-claims` | b | 0.4 | ≥ 0.5 |"
    rows = claims_pages.times({"aqvc-claims": run}).splitlines()[2:]
    assert rows[0] == "| `viscache reproduce aqvc-claims` | 2026-11-26 | C | 0.1 | 0.2 | 1 of 2 |"
    assert rows[1] == "| all 1 | | | 0 | 0 | 1 of 2 |"


def test_an_interval_is_written_in_words():
    assert interval(2.0, 2.0) == "2" and interval(51_208, 51_208) == "51208"
    assert interval(1.45, math.inf) == "≥ 1.45" and interval(0.0, 0.489) == "≤ 0.489"
    assert interval(-1.0, -0.99) == "-1 to -0.99" and interval(-math.inf, 2.0) == "≤ 2"

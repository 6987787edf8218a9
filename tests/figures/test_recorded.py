"""docs/limits.md lists the claims that the figures declare and full runs did not find."""

from __future__ import annotations

import re
from dataclasses import replace

import pytest

from codebase.repository import text
from viscache.figures import FIGURES
from viscache.figures.recorded import RECORDED, Recorded, table

BEGIN, END = "<!-- claims not found -->\n", "<!-- end of claims not found -->"
BY_WHAT = {one.what: one for one in RECORDED}
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


def test_limits_lists_the_claims_that_were_not_found() -> None:
    listed = text("docs/limits.md").partition(BEGIN)[2].partition(END)[0]
    assert listed.strip() == table().strip()


@pytest.mark.parametrize("what", BY_WHAT)
def test_a_recorded_value_is_the_one_of_its_page(what: str) -> None:
    one = BY_WHAT[what]
    assert one.figure in FIGURES and one.band.claim is not None
    assert stands(one)


def test_a_value_that_its_page_does_not_hold_is_noticed() -> None:
    assert not stands(replace(FLICKER, written="0.53"))
    assert not stands(replace(FLICKER, written=".54"))
    assert not stands(replace(FLICKER, section="Figure 7"))


def test_only_what_was_not_found_is_listed() -> None:
    assert FLICKER.found is False and "| ≤ 0.1 | [0.54](" in table([FLICKER])
    better = replace(FLICKER, written="0.05")
    assert better.found and "0.05" not in table([better])
    assert replace(FLICKER, written="9 %").measured == 0.09
    listed = [one.figure for one in RECORDED if one.found is False]
    assert listed == [
        *("aqvc-fig6", "aqvc-fig6", "aqvc-fig7", "aqvc-fig8"),
        *("aqvc-claims", "aqvc-claims", "vlf-tab1"),
    ]

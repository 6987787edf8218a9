"""Two verdicts per figure: the paper's claim and our expectation, on rows made up by hand."""

import math

import pytest

from viscache_lab.experiment import Band, Row
from viscache_lab.experiment.claim_rules import Claim
from viscache_lab.experiment.verdict import claims_not_found, sentence, verdicts

#: The paper says 8 and more; we expect 2 and more.
WIDER = Band(2.0, math.inf, "Sec. 5.2: 8; expected: 2 and more", claimed=Claim.by("at_least", 8.0))
QUOTED = Band(1.0, math.inf, "Fig. 6: the field is faster", claimed=Claim.by("more"))
OURS = Band(1.0, math.inf, "expected: more than none")


def row(band, measured):
    return Row("x", measured, band=band).as_dict()


@pytest.mark.parametrize(
    ("band", "measured", "found", "holds"),
    [
        (WIDER, 8.0, True, True),
        (WIDER, 3.7, False, True),
        (WIDER, 1.0, False, False),
        (QUOTED, 1.5, True, True),
        (QUOTED, 0.5, False, False),
        (QUOTED, None, False, False),
        (QUOTED, math.nan, False, False),
        (OURS, 0.5, None, False),
        (None, 0.5, None, None),
    ],
)
def test_a_row_tells_the_claim_and_the_band_apart(band, measured, found, holds):
    made = row(band, measured)
    assert (made["found"], made["holds"]) == (found, holds)


def test_the_claim_of_a_row_is_data():
    assert row(WIDER, 3.0)["claim"] == [8.0, math.inf]
    assert row(QUOTED, 3.0)["claim"] == [1.0, math.inf]
    assert row(WIDER, 3.0)["rule"] == "at_least" and row(OURS, 3.0)["rule"] is None
    assert row(OURS, 3.0)["claim"] is None and row(None, 3.0)["claim"] is None


def test_a_figure_has_one_verdict_of_each_kind():
    rows = [row(WIDER, 9.0), row(OURS, 2.0), row(None, 1.0)]
    assert verdicts(rows, quick=False, figure="vlf-fig6") == {
        "claim": {"verdict": "found", "yes": 1, "all": 1},
        "expectation": {"verdict": "holds", "yes": 2, "all": 2},
    }
    rows.append(row(WIDER, 3.7))
    found = verdicts(rows, quick=False, figure="vlf-fig6")
    assert found["claim"] == {"verdict": "not found", "yes": 1, "all": 2}
    assert found["expectation"]["verdict"] == "holds"
    assert verdicts([row(OURS, 0.0)], quick=False, figure="vlf-fig6") == {
        "claim": {"verdict": "not stated", "yes": 0, "all": 0},
        "expectation": {"verdict": "does not hold", "yes": 0, "all": 1},
    }
    assert verdicts([], quick=False, figure="vlf-fig6")["expectation"]["verdict"] == "no band"


def test_both_verdicts_are_one_line():
    rows = [row(WIDER, 3.7)]
    said = "The paper's claim: not found (0 of 1). Our expectation: holds (1 of 1)"
    assert sentence(rows, quick=False, figure="vlf-fig6") == f"{said}."
    assert sentence(rows, quick=True, figure="vlf-fig6") == f"{said}, at quick sizes."
    assert sentence([], quick=True, figure="vlf-fig6").startswith("The paper's claim: not judged.")
    ours = "The paper's claim: not stated."
    assert sentence([], quick=True, figure="trade").startswith(ours)
    assert sentence([], quick=False, figure="vlf-fig6") == f"{ours} Our expectation: no band."


def test_claims_not_found_name_their_figure():
    results = [{"figure": "a", "rows": [row(WIDER, 3.7), row(WIDER, 9.0), row(OURS, 0.0)]}]
    assert [(r["figure"], r["measured"]) for r in claims_not_found(results)] == [("a", 3.7)]

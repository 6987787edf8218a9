"""The fuzzer finds what it looks for: crashes, hangs, wrong results and errors that say nothing."""

import itertools
import os
import time

import numpy as np
import pytest

import viscache as vc
from fuzz import campaign
from fuzz.forked import outcome
from fuzz.outcome import WrongError


def raising(error):
    def case():
        raise error

    return case


@pytest.mark.parametrize(
    ("case", "kind"),
    [
        (os.abort, "killed"),
        (lambda: all(itertools.count(1)), "hangs"),
        (lambda: time.sleep(60), "hangs"),
        (raising(WrongError("a colour is negative")), "wrong"),
        (raising(ValueError("")), "unclean"),
        (raising(TypeError("'int' object is not iterable")), "unclean"),
        (raising(KeyError("frames")), "unclean"),
    ],
)
def test_what_no_user_may_meet_is_found(case, kind, tmp_path):
    found = outcome(case, tmp_path, limit_s=1.0)
    assert (found.kind, found.allowed) == (kind, False)


def test_work_and_refusals_are_allowed(tmp_path):
    assert outcome(lambda: None, tmp_path).kind == "works"
    refused = outcome(lambda: vc.Direct(n_area=-1), tmp_path)
    assert refused.kind == "refused" and "n_area must be" in refused.text
    big = outcome(lambda: np.ones(1 << 36, np.uint8), tmp_path)
    assert big.kind == "refused" and "MemoryError" in big.text  # by the limit of the child


def test_a_finding_is_named_by_its_seed(tmp_path):
    def case(seeded):
        if seeded.random() < 0.5:
            raise KeyError("a")

    counts, bad = campaign.run(case, "name", tmp_path, seconds=0, first=7)
    assert sum(counts.values()) == 5 and counts["unclean"] == len(bad) > 0
    seed = int(bad[0].split("seed ")[1].split(":")[0])
    assert campaign.one(case, "name", seed, tmp_path).kind == "unclean"


def test_a_campaign_ends_after_its_cases(tmp_path):
    counts, bad = campaign.run(lambda _: None, "name", tmp_path, seconds=600, cases=7)
    assert sum(counts.values()) == 7 and not bad
    few, _ = campaign.run(lambda _: None, "name", tmp_path, seconds=0, cases=2)
    assert sum(few.values()) == 2

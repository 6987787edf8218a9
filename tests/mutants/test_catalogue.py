"""The list of mutants fits the sources, and `scripts/mutants` tells which of them die."""

from pathlib import Path

import pytest

from mutants import run
from viscache import _core

EVERY = run.catalogue()


def test_mutants_have_names_of_their_own():
    names = [mutant.name for mutant in EVERY]
    assert len(names) > 60 and len(set(names)) == len(names)  # of both files


@pytest.mark.parametrize("mutant", EVERY, ids=lambda m: m.name)
def test_a_mutant_fits_its_file(mutant):
    source = (run.ROOT / mutant.file).read_text(encoding="utf-8")
    changed = mutant.applied(source)
    assert changed != source and mutant.replacement in changed
    assert mutant.is_core == (f'mutant("{mutant.name}")' in changed)
    for test in mutant.tests:
        assert (run.ROOT / test.partition("::")[0]).is_file(), test


def test_a_text_that_is_gone_is_an_error():
    with pytest.raises(ValueError, match=r"must hold .* once, got 0"):
        EVERY[0].applied("int main() {}")


def test_mutants_of_one_file_are_built_together():
    made = run.mutated_core(EVERY)
    picks = made["cpp/viscache/render/light_pick.cpp"].decode()
    assert picks.count("viscache::mutant(") == 2
    assert picks.count('#include "viscache/mutant.h"') == 1


def test_released_code_has_no_trace_of_mutants():
    module = Path(_core.__file__).read_bytes()
    assert b"VISCACHE_MUTANT" not in module
    assert not [m.name for m in EVERY if m.is_core and m.name.encode() in module]


@pytest.mark.parametrize(
    ("status", "dead"), [(0, False), (1, True), (2, False), (4, False), (5, False), (-11, True)]
)
def test_only_tests_that_fail_kill_a_mutant(status, dead, monkeypatch):
    def pytest_says(*_):
        return status, "said"

    monkeypatch.setattr(run, "pytest", pytest_says)
    assert run.dies(EVERY[0]) == (dead, "said")

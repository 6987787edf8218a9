"""Bytes equal the stored digests."""

import json
from pathlib import Path

import pytest

from golden.cases import cases

DIGESTS: dict[str, str] = json.loads(Path(__file__).with_name("digests.json").read_text())
CASES = cases()


def test_every_case_has_a_digest() -> None:
    assert set(CASES) == set(DIGESTS)
    assert len(set(DIGESTS.values())) > 0.9 * len(DIGESTS)


@pytest.mark.parametrize("name", CASES)
def test_bytes_are_those_of_before(name: str) -> None:
    assert CASES[name]() == DIGESTS[name]

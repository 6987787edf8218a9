"""Structures that are freed leave no memory behind."""

import subprocess
import sys
from pathlib import Path

import pytest

from memory.cycles import STRUCTURES

CYCLES = 150
MOST = CYCLES << 10
CONTROL = "leak of 2 kB"


def growth(structure):
    """In a process of its own, so that other structures do not blur it."""
    script = Path(__file__).with_name("cycles.py")
    done = subprocess.run(
        [sys.executable, script, structure, str(CYCLES), str(MOST)],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr[-2000:]
    return int(done.stdout)


@pytest.mark.slow
@pytest.mark.parametrize("structure", [name for name in STRUCTURES if name != CONTROL])
def test_structures_leave_less_than_a_kibibyte_each(structure):
    assert growth(structure) < MOST


@pytest.mark.slow
def test_a_leak_is_found():
    assert growth(CONTROL) > MOST

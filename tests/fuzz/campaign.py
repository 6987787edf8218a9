"""Cases of one target, seed after seed, for some seconds or a number of cases."""

import random
import time
from collections import Counter
from collections.abc import Callable
from pathlib import Path

from fuzz.forked import outcome
from fuzz.outcome import Outcome

#: Makes a case of a seeded generator, and runs it.
Target = Callable[[random.Random], object]


def one(target: Target, name: str, seed: int, folder: Path) -> Outcome:
    """The outcome of one case, which `name` and `seed` decide alone."""
    return outcome(lambda: target(random.Random(f"{name} {seed}")), folder)


def run(
    target: Target,
    name: str,
    folder: Path,
    *,
    seconds: float,
    cases: int | None = None,
    first: int = 0,
) -> tuple[Counter[str], list[str]]:
    """How many cases came to what, and a line for each that no user may meet.

    It ends after the seconds, but not before five cases, or after `cases`, whichever is first.
    """
    counts: Counter[str] = Counter()
    bad: list[str] = []
    end, seed = time.monotonic() + seconds, first
    last = None if cases is None else first + cases
    while seed != last and (time.monotonic() < end or seed < first + 5):
        found = one(target, name, seed, folder)
        counts[found.kind] += 1
        if not found.allowed:
            bad.append(f"{name}, seed {seed}: {found.kind}: {found.text}")
            if len(bad) == 20:
                break
        seed += 1
    return counts, bad

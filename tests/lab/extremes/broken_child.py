"""A process of the checks with a family that crashes, hangs, raises and gives no number."""

import os
import signal
import sys
import time
from collections.abc import Iterator

from viscache_lab.experiment import FAMILIES, Case, Experiment, children


def crash() -> float:
    os.kill(os.getpid(), signal.SIGSEGV)
    return 0.0


def hang() -> float:
    time.sleep(600)
    return 0.0


def raise_() -> float:
    raise RuntimeError("something is wrong")


def cases(full: bool) -> Iterator[Case]:
    for name, measure in {
        "fine": lambda: 0.0,
        "crashes": crash,
        "hangs": hang,
        "raises": raise_,
        "no number": lambda: float("nan"),
        "too large": lambda: 2.0,
        "fine again": lambda: 1.0,
    }.items():
        yield Case(name=name, measure=measure, limit=1, why="made up")


def stops(full: bool) -> Iterator[Case]:
    yield Case(name="fine", measure=lambda: 0.0, why="made up")
    raise RuntimeError("no more cases")


def ends(full: bool) -> Iterator[Case]:
    yield Case(name="fine", measure=lambda: 0.0, why="made up")
    os._exit(3)


for name, made in {"broken": cases, "stops": stops, "ends": ends}.items():
    FAMILIES[name] = Experiment(description="made up", function=made)

if __name__ == "__main__":
    children.child(sys.argv[1], int(sys.argv[2]), int(sys.argv[3]), sys.argv[4] == "full")

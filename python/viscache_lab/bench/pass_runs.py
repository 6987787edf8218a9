"""Passes of one picture, timed one by one."""

from __future__ import annotations

import time
from dataclasses import dataclass, field

import numpy as np

import viscache as vc

__all__ = ["Run", "take_turns"]


@dataclass
class Run:
    """A method: its picture, CPU seconds and the energy of each pass."""

    picture: vc.Progressive
    cpu_s: float = 0.0
    energies: list[float] = field(default_factory=list)

    def add_pass(self) -> None:
        before = sum(self.energies)
        start = time.process_time()
        frame = self.picture.passes(1)
        self.cpu_s += time.process_time() - start
        total = float(frame.image.sum(dtype=np.float64)) * self.picture.n_passes
        self.energies.append(total - before)


def take_turns(runs: list[Run], passes: int) -> None:
    """Pass by pass, so that what else the machine does meets all methods alike."""
    for i in range(passes):
        for run in runs if i % 2 == 0 else runs[::-1]:
            run.add_pass()

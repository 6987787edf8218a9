"""What corrections learn of a cache in one pass, for later passes."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from viscache import _core

__all__ = ["GROUPS", "PassMemory", "octaves_of"]

#: Light groups in the order of the core, and classes of answers of each.
GROUPS = (
    "point",
    "directional",
    "area",
    "environment",
    "vpl",
    "ambient",
    "connection",
    "camera",
)
N_CLASSES = 8
#: The share of a class reaches 1 at `certain` · 2^(octave - 1). Octave 1 is for answers of which
#: one in six is wrong.
PLAIN_OCTAVE, MOST_OCTAVES = 1, 4
PLAIN_WRONG = 0.16
#: Checked answers of a class below which its share stays that of the worst.
LEAST_CHECKED = 64


@dataclass(frozen=True)
class PassMemory:
    """What a pass takes over from those before it.

    Attributes
    ----------
    lights : _core.KeptLights
        Shared lights, filled by the first pass.
    octaves : list of 8 lists of 8 int, optional
        By light group and class: where the share of corrections reaches 1. They come from passes of
        other epochs, whose draws are independent of this one's.
    epoch : int
        Passes of one epoch take turns at the samples of a pixel; epochs draw independently.
    """

    lights: _core.KeptLights
    octaves: list[list[int]] | None = None
    epoch: int = 0


def unlearnt() -> list[list[int]]:
    """Octaves before anything is known."""
    return [[PLAIN_OCTAVE] * N_CLASSES for _ in GROUPS]


def octaves_of(share_by_class: Mapping[str, Any]) -> list[list[int]]:
    """Octaves for the classes of a frame's counters "share_by_class".

    The variance of corrections is least where the share is proportional to c·√p, with p the
    probability of a wrong answer: half an octave of p is one of the share.
    """
    octaves = unlearnt()
    for name, classes in share_by_class.items():
        for k, counted in enumerate(classes.values()):
            if counted["corrections"] < LEAST_CHECKED:
                continue
            p = max(counted["wrong"], 0.5) / counted["corrections"]
            octave = PLAIN_OCTAVE + round(0.5 * math.log2(PLAIN_WRONG / p))
            octaves[GROUPS.index(name)][k] = min(max(octave, 0), MOST_OCTAVES)
    return octaves

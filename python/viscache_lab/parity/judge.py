"""Renders a file with both until the verdict is clear, or the samples are spent."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, Literal, TypeAlias, get_args

import numpy as np
import numpy.typing as npt

from viscache_lab.parity.blocks import Comparison, block_means, compare
from viscache_lab.parity.renderers import Loaded, load_mitsuba, load_viscache

FloatImage = npt.NDArray[np.floating[Any]]
Verdict: TypeAlias = Literal[
    "differs", "not loaded", "not comparable", "warned", "warned though right", "agrees"
]
#: All verdicts, the worst first.
VERDICTS: tuple[Verdict, ...] = get_args(Verdict)

#: Pictures smaller than this have blocks of 8 × 8 pixels, others of 16 × 16.
SMALL_PX = 128


@dataclass(frozen=True, kw_only=True, slots=True)
class Effort:
    """Samples per pixel of each picture; pictures of each renderer to begin with, doubled up to the
    most; and the relative difference of a block that must be found before an agreement is clear.
    """

    spp: int = 16
    first: int = 6
    most: int = 48
    power: float = 0.05


FULL = Effort()
QUICK = Effort(first=5, most=10, power=0.12)


@dataclass(frozen=True, kw_only=True, slots=True)
class Judged:
    """A file, its verdict, and what it rests on."""

    name: str
    verdict: Verdict
    warnings: list[str]  # of our loader; for a file that is not loaded, the error
    mitsuba: list[str]  # Mitsuba's warnings or its error
    why: str = ""
    about: str = ""  # who writes such files and what is right, where no renderer is asked
    compared: Comparison | None = None
    ours: FloatImage | None = None  # mean picture
    theirs: FloatImage | None = None
    pictures: int = 0

    @property
    def silent_miss(self) -> bool:
        """Whether the picture is wrong and nothing was said."""
        return self.verdict == "differs"

    @property
    def severity(self) -> float:
        """How much of the picture is wrong."""
        c = self.compared
        return 2.0 if c is None else 1 - c.share + min(abs(c.energy_difference), 1.0)


def judge(
    mi: Any, name: str, path: Path, *, effort: Effort = FULL, threads: int | None = None
) -> Judged:
    """Load and render a Mitsuba 3 file with both renderers, and compare; threads are of ours."""
    mine, other = load_viscache(path, threads), load_mitsuba(mi, path)
    return judge_pair(name, mine, other, effort=effort)


def judge_pair(
    name: str, mine: Loaded, other: Loaded, *, effort: Effort = FULL, about: str = ""
) -> Judged:
    """Compare two loaded files; `about` tells of a picture that is right by a formula."""
    judged = partial(Judged, name=name, warnings=mine.warnings, mitsuba=other.warnings, about=about)
    if mine.render is None:
        return judged(verdict="not loaded", why=mine.warnings[0])
    if other.render is None:
        return judged(verdict="not comparable", why=f"Mitsuba: {other.warnings[0]}")
    pair = _Side(mine.render, effort.spp), _Side(other.render, effort.spp)
    for side in pair:
        side.grow(1)
    if pair[0].size != pair[1].size:
        why = f"sizes of the pictures: {pair[0].size} and {pair[1].size}"
        return judged(verdict="warned" if mine.warnings else "differs", why=why)
    count = effort.first
    compared = _compared(pair, count)
    # No number of samples changes the verdict on a file that is warned of
    most = effort.first if mine.warnings else effort.most
    while count < most and not _clear(compared, effort):
        count = min(2 * count, most)
        compared = _compared(pair, count)
    verdict, why = _verdict(compared, mine.warnings, other.warnings)
    # A formula has no noise that would hide a difference
    if about and verdict == "warned" and compared.agrees:
        verdict = "warned though right"
    ours, theirs = (np.asarray(side.total / count) for side in pair)
    return judged(
        verdict=verdict, why=why, compared=compared, ours=ours, theirs=theirs, pictures=count
    )


def _compared(pair: tuple[_Side, _Side], count: int) -> Comparison:
    """The comparison of so many pictures of each."""
    for side in pair:
        side.grow(count)
    return compare(*(np.stack(side.blocks) for side in pair))


def _clear(compared: Comparison, effort: Effort) -> bool:
    """Whether more samples would hardly change the verdict."""
    if compared.agrees:
        return compared.share >= 0.98 and compared.power <= effort.power
    return compared.share < 0.7


def _verdict(compared: Comparison, warnings: list[str], mitsubas: list[str]) -> tuple[Verdict, str]:
    if not compared.informative and (compared.agrees or mitsubas):
        if np.isfinite(compared.power):
            return (
                "not comparable",
                f"the noise hides differences of less than {compared.power:.0%}",
            )
        black = "both pictures are" if compared.energy_ours == 0 else "Mitsuba's picture is"
        return "not comparable", f"{black} black" + (f": {mitsubas[0]}" if mitsubas else "")
    if warnings:
        return "warned", warnings[0]
    if compared.agrees:
        return "agrees", ""
    if mitsubas:  # it says itself that it does not do what the file asks for
        return "not comparable", f"Mitsuba: {mitsubas[0]}"
    if compared.share < 1 and not compared.energies_agree:
        return "differs", f"energy {compared.energy_difference:+.1%}"
    return "differs", f"{1 - compared.share:.0%} of the blocks"


class _Side:
    """Block means of the pictures of a renderer, and the sum of the pictures."""

    def __init__(self, render: Callable[[int, int], FloatImage], spp: int) -> None:
        self.render, self.spp = render, spp
        self.blocks: list[FloatImage] = []
        self.total: Any = 0

    @property
    def size(self) -> tuple[int, int]:
        """Width and height."""
        height, width = self.total.shape[:2]
        return width, height

    def grow(self, count: int) -> None:
        """Render until there are so many pictures."""
        for seed in range(len(self.blocks), count):
            picture = np.asarray(self.render(self.spp, seed), np.float64)
            edge = 8 if min(picture.shape[:2]) < SMALL_PX else 16
            self.blocks.append(block_means(picture, edge))
            self.total = self.total + picture

"""Integer sums over pairs of points, by groups, distance and angle."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from viscache.base.formats import ArrayField, Format
from viscache.settings.checks import require

Floats: TypeAlias = npt.NDArray[np.float64]
Ints: TypeAlias = npt.NDArray[np.int64]

#: Names of the integer arrays of a table, also in its file.
SUMS = ("n", "n_undefined", "sum_q", "sum_q2_high", "sum_q2_low")
FORMAT = Format(
    kind="a file of PairTable.to_npz",
    version=1,
    arrays={
        **dict.fromkeys(SUMS, ArrayField("i8", ("P", "D", "A"))),
        "d_edges": ArrayField("f8", ("D + 1",)),
        "theta_edges_deg": ArrayField("f8", ("A + 1",)),
    },
)
#: Maximum number of pairs in a cell, so that Σ q fits into 63 bits.
MAX_PAIRS = 1 << 42


@dataclass(frozen=True, kw_only=True, eq=False)
class PairTable:
    """Sums over pairs, by pair of groups, bin of distance and bin of angle.

    Attributes
    ----------
    n, n_undefined : (P, D, A) int64
        Number of pairs with ρ, and of pairs without ρ because a row has too few bits or all of
        them. The group pairs (g, h), g <= h, are in the order (0, 0), (0, 1), …, (1, 1), …
    sum_q : (P, D, A) int64
        Σ q over the n pairs, q = round(ρ·2²⁰).
    sum_q2_high, sum_q2_low : (P, D, A) int64
        Σ q² = high·2³² + low with 0 <= low < 2³².
    d_edges : (D + 1,) float64
        Half-open bins of distance, in scene units.
    theta_edges_deg : (A + 1,) float64
        Half-open bins of the angle between normals, in degrees. A last edge of 180 is included.
    """

    n: Ints
    n_undefined: Ints
    sum_q: Ints
    sum_q2_high: Ints
    sum_q2_low: Ints
    d_edges: Floats
    theta_edges_deg: Floats

    def __post_init__(self) -> None:
        cells = (len(self.n), len(self.d_edges) - 1, len(self.theta_edges_deg) - 1)
        for name in SUMS:
            array = getattr(self, name)
            fits = array.shape == cells and array.dtype == np.int64
            require(fits, f"{name} must be int64 of shape {cells}", (array.dtype, array.shape))

    def __add__(self, other: PairTable) -> PairTable:
        """Add the sums of another set of pairs.

        Raises
        ------
        ValueError
            Bins or groups differ, or a cell has more than 2⁴² pairs.
        """
        if not isinstance(other, PairTable):
            return NotImplemented
        for name in ("d_edges", "theta_edges_deg"):
            same = np.array_equal(getattr(self, name), getattr(other, name))
            require(same, f"{name} must be the same in both tables", getattr(other, name))
        require(self.n.shape == other.n.shape, "groups must be the same in both", other.n.shape)
        sums = {name: getattr(self, name) + getattr(other, name) for name in SUMS}
        most = int(sums["n"].max(initial=0))
        require(most <= MAX_PAIRS, f"a cell must hold at most {MAX_PAIRS} pairs", most)
        sums["sum_q2_high"] += sums["sum_q2_low"] >> 32
        sums["sum_q2_low"] &= 0xFFFFFFFF
        return PairTable(**sums, d_edges=self.d_edges, theta_edges_deg=self.theta_edges_deg)

    def sum_q2(self) -> npt.NDArray[np.object_]:
        """Σ q² as Python integers, (P, D, A)."""
        high, low = (x.astype(object) for x in (self.sum_q2_high, self.sum_q2_low))
        total: npt.NDArray[np.object_] = high * (1 << 32) + low
        return total

    def to_npz(self, path: str | Path) -> None:
        """Save; `from_npz` reads it back."""
        arrays = {name: getattr(self, name) for name in FORMAT.arrays}
        FORMAT.write_npz(Path(path), {}, arrays, compressed=True)

    @classmethod
    def from_npz(cls, path: str | Path) -> PairTable:
        """Read a saved table.

        Raises
        ------
        ValueError
            The file is no such table, or damaged.
        """
        _, arrays = FORMAT.read_npz(Path(path))
        try:
            return cls(**arrays)
        except ValueError as error:
            raise FORMAT.refusal(path, error) from error

"""Computes means, standard deviations and standard errors from integer sums over pairs of groups.

A pair (i, j) adds q = round(ρ·2²⁰) and q² to its cell, separately for each pair of spatial groups.
Every statistic below is a function of integers, so the bytes do not depend on how the pairs were
divided into blocks.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from viscache.correlation.bins import Floats, merge
from viscache.correlation.pairs import SCALE

Ints = npt.NDArray[np.int64]
#: Python integers, because sums of squares need more than 64 bits.
Wide = npt.NDArray[np.object_]


@dataclass(frozen=True, kw_only=True, slots=True)
class Sums:
    """Integer sums over the pairs of every cell (D, T), for each of P pairs of groups.

    `n` has pairs with defined ρ, `n_undefined` the others, `q` is Σ q: (P, D, T) int64. `q2` is Σ
    q² over all P: (D, T) Python integers. `first` and `second` (P,) are the two groups.
    """

    n: Ints
    n_undefined: Ints
    q: Ints
    q2: Wide
    first: Ints
    second: Ints

    def merged(self, axis: int, cells: Floats, edges: Floats) -> Sums:
        """Merge cells into bins along d (axis 0) or θ (axis 1)."""
        return Sums(
            n=merge(self.n, axis + 1, cells, edges),
            n_undefined=merge(self.n_undefined, axis + 1, cells, edges),
            q=merge(self.q, axis + 1, cells, edges),
            q2=merge(self.q2, axis, cells, edges),
            first=self.first,
            second=self.second,
        )

    def with_near(self, near: Sums, n_cells: int) -> Sums:
        """These sums with the first cells of d replaced by those of the near pass."""

        def joined(far: Any, close: Any, axis: int) -> Any:
            rest = np.take(far, range(n_cells, far.shape[axis]), axis=axis)
            return np.concatenate([np.take(close, range(n_cells), axis=axis), rest], axis=axis)

        return Sums(
            n=joined(self.n, near.n, 1),
            n_undefined=joined(self.n_undefined, near.n_undefined, 1),
            q=joined(self.q, near.q, 1),
            q2=joined(self.q2, near.q2, 0),
            first=self.first,
            second=self.second,
        )


@dataclass(frozen=True, kw_only=True, slots=True)
class Statistics:
    """Statistics (D, T) of every bin; NaN if a bin has too few pairs.

    `mean`, `mean_square` and `sigma` are of ρ; σ is the spread of the pairs. `se` is the standard
    error of the mean by the jackknife over spatial groups. `se_naive` is σ/√n, as if pairs were
    independent. It is far too small, because pairs share points.
    """

    mean: Floats
    sigma: Floats
    mean_square: Floats
    se: Floats
    se_naive: Floats
    n: Ints
    n_undefined: Ints


def statistics(sums: Sums) -> Statistics:
    """Statistics of sums; the mean is Σq / (n·2²⁰), the variance (n Σq² − (Σq)²) / (n·2²⁰)²."""
    n, total = sums.n.sum(axis=0), sums.q.sum(axis=0)
    count, first = n.astype(object), total.astype(object)
    some = n > 0
    mean, sigma, square = (np.full(n.shape, np.nan) for _ in range(3))
    mean[some] = total[some] / n[some] / SCALE
    spread = count[some] * sums.q2[some] - first[some] ** 2
    sigma[some] = np.sqrt((spread / count[some] ** 2).astype(np.float64)) / SCALE
    square[some] = (sums.q2[some] / count[some]).astype(np.float64) / SCALE**2
    naive = np.full(n.shape, np.nan)
    naive[some] = sigma[some] / np.sqrt(n[some])
    return Statistics(
        mean=mean,
        sigma=sigma,
        mean_square=square,
        se=jackknife(sums),
        se_naive=naive,
        n=n,
        n_undefined=sums.n_undefined.sum(axis=0),
    )


def jackknife(sums: Sums) -> Floats:
    """Standard error (D, T) of the mean ρ by the jackknife over spatial groups.

    Leaving out group g removes all pairs with an end in g. Let m₍g₎ be the mean without g, m̄ the
    mean of the m₍g₎ and G the number of groups: SE² = (G − 1)/G · Σ (m₍g₎ − m̄)². NaN for one
    group, and where all pairs of a bin have an end in the same group.
    """
    groups = int(sums.second.max()) + 1 if len(sums.second) else 0
    n, q = sums.n.sum(axis=0), sums.q.sum(axis=0)
    left_out = np.full((groups, *n.shape), np.nan)
    for g in range(groups):
        touched = (sums.first == g) | (sums.second == g)
        rest = n - sums.n[touched].sum(axis=0)
        some = rest > 0
        kept = q - sums.q[touched].sum(axis=0)
        left_out[g][some] = kept[some] / rest[some] / SCALE
    if groups < 2:
        return np.full(n.shape, np.nan)
    deviation = left_out - left_out.sum(axis=0) / groups
    return np.asarray(np.sqrt((groups - 1) / groups * (deviation**2).sum(axis=0)))

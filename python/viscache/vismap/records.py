"""What a cache of visibility maps hands out: its records, look-ups, and what an update did."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

__all__ = ["Lookup", "Records", "UpdateReport"]

Floats: TypeAlias = npt.NDArray[np.float32]


@dataclass(frozen=True, kw_only=True, slots=True)
class Records:
    """Copies of what the cache holds, one row per record."""

    positions: Floats
    """(N, 3)"""
    normals: Floats
    """(N, 3), unit."""
    bits: npt.NDArray[np.uint64]
    """(N, 4^m / 64): cell z, in Z order (Eq. 10), is bit z % 64 of word z // 64; 1 = free."""
    rays: npt.NDArray[np.uint32]
    """(N,) exact rays the record was compared with."""
    misses: npt.NDArray[np.uint32]
    """(N,) of these, where its map was wrong."""
    last_used: npt.NDArray[np.uint32]
    """(N,) frame."""
    ambient: Floats
    """(N,) A of Eq. 12, divided by π."""
    nearest_hit: Floats
    """(N,) R; inf where nothing is hit, or with criterion "visibility"."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Lookup:
    """What is blended at N points: Ṽ(x, ω) = Σ β_i V_i(ω) (Eq. 8)."""

    ids: npt.NDArray[np.int64]
    """(N, n_best) records, heaviest first; −1 where there are fewer."""
    beta: Floats
    """(N, n_best) their shares, which sum to 1, or to 0 where there is no approximation."""
    candidates: npt.NDArray[np.int32]
    """(N,) records in reach with similar normals, at most m_nearest."""
    weight: Floats
    """(N,) the greatest weight, as held against w_min."""
    difference: Floats
    """(N,) mean difference of the blended maps (Eq. 11); 0 of fewer than two."""


@dataclass(frozen=True, kw_only=True, slots=True)
class UpdateReport:
    """What an update did."""

    frame: int
    inserted: int
    """New records: startup + no_candidate + weight + difference."""
    startup: int
    no_candidate: int
    """Inserted because no record was in reach."""
    weight: int
    """Inserted because none weighed as much as w_min."""
    difference: int
    """Inserted because the blended maps differed by more than delta_max."""
    suppressed: int
    """Pixels whose maps differ too much but where a record is too near for another."""
    duplicates: int
    """Pixels, or start-up rays, where a record with the same normal stands already."""
    refused: int
    """Pixels that wanted a record when max_records were there."""
    rays: int
    """Rays traced for the new records."""
    lookups: int
    passes: int
    pixels: int
    misses: int
    """Pixels that see no surface."""
    bad_normals: int
    """Pixels whose triangle has no normal: never served, never given a record."""

"""Data returned by a cache of visibility maps: records, lookups, reports, bits of cells."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from viscache import _core
from viscache.settings.checks import require

MAX_PIXELS = 1 << 28

Floats: TypeAlias = npt.NDArray[np.float32]


@dataclass(frozen=True, kw_only=True, slots=True)
class Records:
    """Copies of the records of a cache, one row per record."""

    positions: Floats
    """(N, 3)"""
    normals: Floats
    """(N, 3), unit."""
    bits: npt.NDArray[np.uint64]
    """(N, 4^m / 64): cell z, in Z order (Eq. 10), is bit z % 64 of word z // 64; 1 = free."""
    rays: npt.NDArray[np.uint32]
    """(N,) number of exact rays compared with the record."""
    misses: npt.NDArray[np.uint32]
    """(N,) of these, number of rays about which the map was wrong."""
    last_used: npt.NDArray[np.uint32]
    """(N,) last frame in which the record was used."""
    ambient: Floats
    """(N,) A of Eq. 12, divided by π."""
    nearest_hit: Floats
    """(N,) R; inf if nothing is hit, or with criterion "visibility"."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Lookup:
    """The records blended at N points: Ṽ(x, ω) = Σ β_i V_i(ω) (Eq. 8)."""

    ids: npt.NDArray[np.int64]
    """(N, n_best) ids in descending order of weight; −1 if there are fewer."""
    beta: Floats
    """(N, n_best) weights with sum 1, or sum 0 where there is no approximation."""
    candidates: npt.NDArray[np.int32]
    """(N,) records in reach with similar normals, at most m_nearest."""
    weight: Floats
    """(N,) the largest weight, as compared with w_min."""
    difference: Floats
    """(N,) mean difference of the blended maps (Eq. 11); 0 for fewer than two."""


@dataclass(frozen=True, kw_only=True, slots=True)
class UpdateReport:
    """Statistics of an update by pixels, or of an insertion at points, which count as pixels."""

    frame: int
    inserted: int
    """New records: startup + no_candidate + weight + difference."""
    startup: int
    no_candidate: int
    """Inserted because no record was in reach."""
    weight: int
    """Inserted because no weight reached w_min."""
    difference: int
    """Inserted because the blended maps differed by more than delta_max."""
    suppressed: int
    """Pixels whose maps differ too much, but where an existing record is too near."""
    duplicates: int
    """Pixels or start-up rays at which a record with the same normal already exists."""
    refused: int
    """Pixels that needed a record when the cache was full."""
    rays: int
    """Rays traced for the new records."""
    lookups: int
    passes: int
    pixels: int
    misses: int
    """Pixels that see no surface, or points with d_max 0."""
    bad_normals: int
    """Pixels whose triangle has no normal: they use no records and get none."""

    @classmethod
    def of(
        cls,
        frame: int,
        startup: dict[str, int],
        found: dict[str, int],
        pixels: int,
        misses: int,
        bad_normals: int,
    ) -> UpdateReport:
        """From what the start-up and the insertion counted."""
        reasons = ("no_candidate", "weight", "difference", "suppressed", "refused")
        counts = {name: found[name] for name in (*reasons, "lookups", "passes")}
        both = {name: startup[name] + found[name] for name in ("inserted", "duplicates", "rays")}
        return cls(
            frame=frame,
            startup=startup["inserted"],
            pixels=pixels,
            misses=misses,
            bad_normals=bad_normals,
            **both,
            **counts,
        )


def checked_size(size: tuple[int, int]) -> tuple[int, int]:
    """Size of an image, if a record can be asked for at each of its pixels."""
    require(size[0] * size[1] <= MAX_PIXELS, "size must be at most 2^28 pixels", size)
    return size


def cells_of(directions: npt.NDArray[np.float32], m: int) -> npt.NDArray[np.int64]:
    """Z-order indices (...) of the cells of unit directions (..., 3)."""
    edge = 1 << m
    at = _core.sampling.direction_to_equal_area(directions.reshape(-1, 3))
    x, y = np.minimum((at * edge).astype(np.uint32), edge - 1).T
    return np.asarray(_core.vismap.morton2(x, y), np.int64).reshape(directions.shape[:-1])


def blended_bits(
    bits: npt.NDArray[np.uint64], ids: npt.NDArray[Any], cells: npt.NDArray[np.int64]
) -> npt.NDArray[np.bool_]:
    """(N, n_best, K): the bit of each record `ids` (N, n_best) in the point's cells (N, K)."""
    rows = np.maximum(ids, 0)[:, :, None]
    at = cells[:, None, :]
    words = bits[rows, at // 64] if len(bits) else np.zeros(np.broadcast(rows, at).shape, "u8")
    found: npt.NDArray[np.bool_] = (words >> (at % 64).astype(np.uint64) & np.uint64(1)) > 0
    return found & (ids >= 0)[:, :, None]

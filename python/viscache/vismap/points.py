"""Points of any source in the form that a cache takes, and orders of pixels."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from viscache import _core
from viscache.oracles.points import neighbour_density
from viscache.settings.checks import checked_points, require
from viscache.vismap.records import Floats

Rows: TypeAlias = npt.NDArray[np.uint32]
Indices: TypeAlias = npt.NDArray[np.int64]

#: Points that are converted for the core together.
TILE = 1 << 20
#: Limits of the default d_max in diagonals of the scene; the upper one is that of pixels.
LEAST_REACH, MOST_REACH = 1e-6, 0.1
#: Counts of an insertion that add up over calls, and those of which the latest per point holds.
SUMMED = ("inserted", "no_candidate", "weight", "difference", "rays", "lookups", "passes")
LATEST = ("suppressed", "duplicates", "refused", "unusable")


@dataclass(frozen=True, eq=False)
class Cloud:
    """N checked points on surfaces, each with a search radius and a footprint."""

    positions: Floats
    normals: Floats
    d_max: Floats
    footprint: Floats

    def __len__(self) -> int:
        return len(self.positions)

    def take(self, rows: Rows | slice) -> _core.vismap.CachePoints:
        """Some of the points in the form of the C++ core."""
        return _core.vismap.CachePoints(
            self.positions[rows], self.normals[rows], self.d_max[rows], self.footprint[rows]
        )

    def order(self) -> Rows:
        """Rows of the points along a Morton curve."""
        return _core.vismap.morton_order(self.positions)

    def tiles(self, order: Rows) -> Iterator[_core.vismap.CachePoints]:
        """The points in this order, `TILE` at a time."""
        for first in range(0, len(order), TILE):
            yield self.take(order[first : first + TILE])


def make_cloud(
    positions: npt.ArrayLike,
    normals: npt.ArrayLike,
    d_max: npt.ArrayLike | None,
    footprint: npt.ArrayLike | None,
    *,
    reach: float,
    extent: float,
) -> Cloud:
    """Check points, and choose their search radii and footprints where none are given.

    Arguments are those of `VisibilityMapCache.insert`; `reach` is `MapSettings.d_max`, `extent` the
    scene's diagonal. ValueError names the row that is out of range.
    """
    places, sides = checked_points(positions, "positions"), checked_points(normals, "normals")
    for name, rows in (("positions", places), ("normals", sides)):
        fits = rows.ndim == 2 and rows.shape[1] == 3
        require(fits, f"{name} must have shape (N, 3)", rows.shape)
    count = len(places)
    require(len(sides) == count, f"normals must have one row per position, {count}", len(sides))
    radii = _per_row(1.0 if d_max is None else d_max, "d_max", count)
    sizes = _per_row(0.0 if footprint is None else footprint, "footprint", count)
    for first in range(0, count, TILE):
        some = slice(first, first + TILE)
        _core.vismap.CachePoints(places[some], sides[some], radii[some], sizes[some], first)
    if footprint is None:
        sizes = _spacing(places)
    if d_max is None:
        radii = _default_reach(sizes, reach, extent)
    return Cloud(places, sides, radii, sizes)


def insert_tiles(
    points: Cloud,
    order: Rows,
    insert: Callable[[_core.vismap.CachePoints], Mapping[str, int]],
    size: Callable[[], int],
    *,
    repeat_passes: bool,
) -> dict[str, int]:
    """Insert records at points tile by tile, in the given order of points.

    `insert` inserts at the points of a tile and gives the counts, `size` is the number of records.
    With `repeat_passes`, tiles are visited again until none needs a record because of another
    one's.
    """
    totals = dict.fromkeys(SUMMED, 0)
    latest: dict[int, Mapping[str, int]] = {}
    size_after: dict[int, int] = {}
    while True:
        before = size()
        for number, tile in enumerate(points.tiles(order)):
            if size_after.get(number) == size():
                continue
            latest[number] = insert(tile)
            size_after[number] = size()
            for name in SUMMED:
                totals[name] += latest[number][name]
        if not repeat_passes or size() == before:
            break
    return totals | {name: sum(found[name] for found in latest.values()) for name in LATEST}


def _per_row(value: npt.ArrayLike, name: str, count: int) -> Floats:
    given = checked_points(value, name)
    fits = np.ndim(value) == 0 or given.shape == (count,)
    require(fits, f"{name} must be one or {count} numbers", given.shape)
    return np.broadcast_to(given.reshape(-1), (count,))


def _spacing(positions: Floats) -> Floats:
    """1 / √density: the edge of the square that a point has for itself; 0 without neighbours."""
    density = neighbour_density(positions)
    spacing = np.zeros_like(density)
    np.divide(1, np.sqrt(density), out=spacing, where=density > 0)
    return spacing


def _default_reach(footprint: Floats, reach: float, extent: float) -> Floats:
    """Search radii as if the points were the pixels of a square image."""
    wide = np.where(footprint > 0, reach * np.sqrt(len(footprint)) * footprint, np.inf)
    return np.clip(wide, LEAST_REACH * extent, MOST_REACH * extent).astype(np.float32)


def pixel_order(order: str, width: int, height: int) -> Indices:
    """Row-major indices of the pixels in the given order.

    "scanline": row by row. "hilbert": along Hilbert's curve. "coarse_to_fine": every 2^k-th pixel
    of every 2^k-th row first, then those half way between them.
    """
    numbers = np.arange(width * height, dtype=np.int64)
    if order == "scanline":
        return numbers
    y, x = np.divmod(numbers, width)
    bits = max(width, height, 2).bit_length()
    key = _hilbert(x, y, bits) if order == "hilbert" else _coarse_to_fine(x, y, bits)
    return np.argsort(key, kind="stable").astype(np.int64)


def _coarse_to_fine(x: Any, y: Any, bits: int) -> Indices:
    """Interleaved reversed bits of both coordinates: coarse positions come first."""
    key = np.zeros_like(x)
    for bit in range(bits):
        key = key << 2 | (x >> bit & 1) << 1 | (y >> bit & 1)
    return np.asarray(key)


def _hilbert(x: Any, y: Any, bits: int) -> Indices:
    """Index along Hilbert's curve."""
    x, y, key = x.copy(), y.copy(), np.zeros_like(x)
    for bit in reversed(range(bits)):
        step = 1 << bit
        right, up = (x & step) > 0, (y & step) > 0
        key += step * step * ((3 * right) ^ up)
        # Turn the quadrant so that the curve within it starts at its origin
        flip = right & ~up
        x, y = np.where(flip, step - 1 - x, x), np.where(flip, step - 1 - y, y)
        x, y = np.where(up, x, y), np.where(up, y, x)
    return np.asarray(key)

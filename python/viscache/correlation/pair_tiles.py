"""Which pairs of points are taken together: blocks of points against blocks of points."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from viscache import _core
from viscache.settings.checks import is_whole, require

#: Maximum number of points along a side of a tile.
TILE = 2048


def tile_list(group: npt.NDArray[np.int32], tile: int = TILE) -> npt.NDArray[Any]:
    """List all tiles of pairs, in their fixed order.

    A tile holds the pairs of two blocks of at most `tile` points, each block within one group.
    Every pair i < j is in exactly one tile. The tiles of a pair of groups have consecutive numbers.

    Parameters
    ----------
    group : (N,) int32
        Group of every point, never decreasing.
    tile : int
        Maximum number of points in a block.

    Returns
    -------
    (K,) structured array
        a, b: groups; i0, i1, j0, j1: points [i0, i1) of a and [j0, j1) of b; pairs: their number.
        If i0 = j0 the tile holds the pairs i < j of its points.
    """
    group = np.asarray(group)
    rows = _core.correlation.tiles(group, group_count(group), tile_side(tile))
    names = ("a", "b", "i0", "i1", "j0", "j1", "pairs")
    return rows.view([(name, np.int64) for name in names]).reshape(-1)


def choose_tiles(
    group: npt.NDArray[np.int32], n_pairs: int, seed: int = 0, tile: int = TILE
) -> npt.NDArray[np.int64]:
    """Choose random tiles with about `n_pairs` pairs in total, without replacement.

    All tiles are equally likely. The same fraction of tiles is taken from each pair of groups; a
    fractional number of tiles is rounded up or down at random, without bias. The numbers increase.
    """
    require(is_whole(n_pairs) and n_pairs >= 1, "n_pairs must be a whole number >= 1", n_pairs)
    tiles = tile_list(group, tile)
    share = min(1.0, n_pairs / max(1, int(tiles["pairs"].sum())))
    random = np.random.Generator(np.random.Philox(seed))
    chosen = []
    new_groups = 1 + np.flatnonzero(np.diff(tiles["a"]) | np.diff(tiles["b"]))
    for numbers in np.split(np.arange(len(tiles)), new_groups):
        count = int(np.floor(share * len(numbers) + random.random()))
        chosen.append(np.sort(random.permutation(numbers)[:count]))
    return np.concatenate(chosen)


def group_count(group: npt.NDArray[np.int32]) -> int:
    """One more than the largest group number."""
    return int(np.max(group, initial=0)) + 1


def tile_side(tile: int) -> int:
    """Validated number of points along the side of a tile."""
    require(is_whole(tile) and tile >= 1, "tile must be a whole number >= 1", tile)
    return int(tile)


def tile_numbers(tiles: npt.ArrayLike) -> list[int]:
    """Validated tile numbers as Python integers."""
    numbers = np.asarray(tiles)
    fits = numbers.ndim == 1 and (numbers.size == 0 or np.issubdtype(numbers.dtype, np.integer))
    require(fits, "tiles must be a list of whole numbers", tiles)
    require(bool((numbers >= 0).all()), "tiles must be >= 0", tiles)
    found: list[int] = numbers.tolist()
    return found

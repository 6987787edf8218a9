"""Statistics of ρ over pairs of points, from their rows of bits.

Every pair adds q = round(ρ·2²⁰) and q² to the cell of its two groups, its distance and its angle.
The sums are integers: tables of parts of the pairs add up to the same bytes in any order, and
neither threads nor instruction sets change them.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, TypeAlias

import numpy as np
import numpy.typing as npt

from viscache import _core
from viscache.checks import is_whole, require
from viscache.progress import progress_bar

__all__ = [
    "SCALE",
    "TILE",
    "PairTable",
    "choose_tiles",
    "intersections",
    "near_pairs",
    "pair_statistics",
    "phi",
    "spatial_map",
    "tile_list",
]

Floats: TypeAlias = npt.NDArray[np.float64]
Ints: TypeAlias = npt.NDArray[np.int64]
Progress: TypeAlias = bool | Callable[[int, int], None]
Domain: TypeAlias = Literal["sphere", "joint", "union"]
Undefined: TypeAlias = Literal["skip", "one_if_both"]

#: q = round(ρ·SCALE).
SCALE = 1 << 20
#: Most points along a side of a tile.
TILE = 2048
#: Integer arrays of a table, as they are called in its file.
SUMS = ("n", "n_undefined", "sum_q", "sum_q2_high", "sum_q2_low")
#: So many pairs of one cell keep Σ q within 63 bits.
MAX_PAIRS = 1 << 42


@dataclass(frozen=True, kw_only=True, eq=False)
class PairTable:
    """Sums over pairs per pair of groups, bin of distance and bin of angle.

    Attributes
    ----------
    n, n_undefined : (P, D, A) int64
        Pairs with a ρ, and pairs without because a row has too few bits or all of them. Group
        pairs (g, h), g <= h, are in order (0, 0), (0, 1), …, (1, 1), …
    sum_q : (P, D, A) int64
        Σ q over the n pairs, q = round(ρ·2²⁰).
    sum_q2_high, sum_q2_low : (P, D, A) int64
        Σ q² = high·2³² + low with 0 <= low < 2³².
    d_edges : (D + 1,) float64
        Bins of distance, half open, scene units.
    theta_edges_deg : (A + 1,) float64
        Bins of the angle between normals, half open, degrees; 180 closes the last bin.
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
        """The table of both sets of pairs.

        Raises
        ------
        ValueError
            Other bins or groups, or more than 2⁴² pairs in a cell.
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
        arrays = {name: getattr(self, name) for name in (*SUMS, "d_edges", "theta_edges_deg")}
        with Path(path).open("wb") as file:
            np.savez_compressed(file, **arrays)

    @classmethod
    def from_npz(cls, path: str | Path) -> PairTable:
        """Read a saved table."""
        with np.load(path) as file:
            missing = {*SUMS, "d_edges", "theta_edges_deg"} - set(file)
            require(not missing, f"{path} must hold the arrays of a PairTable", sorted(file))
            return cls(**dict(file))


def tile_list(group: npt.NDArray[np.int32], tile: int = TILE) -> npt.NDArray[Any]:
    """All tiles of pairs, in their fixed numbering.

    A tile holds the pairs of two blocks of at most `tile` points, each within one group; all pairs
    i < j of the points lie in exactly one. Tiles of a pair of groups have consecutive numbers.

    Parameters
    ----------
    group : (N,) int32
        Group of every point, never decreasing.
    tile : int
        Points along a block's edge, at most.

    Returns
    -------
    (K,) structured array
        a, b: groups; i0, i1, j0, j1: points [i0, i1) of a and [j0, j1) of b; pairs. Where i0 = j0
        the tile holds the pairs i < j of its points.
    """
    group = np.asarray(group)
    rows = _core.correlation.tiles(group, _groups(group), _tile(tile))
    names = ("a", "b", "i0", "i1", "j0", "j1", "pairs")
    return rows.view([(name, np.int64) for name in names]).reshape(-1)


def choose_tiles(
    group: npt.NDArray[np.int32], n_pairs: int, seed: int = 0, tile: int = TILE
) -> npt.NDArray[np.int64]:
    """Numbers of random tiles that hold about `n_pairs` pairs, without replacement.

    Every tile is as likely as any other, and of each pair of groups the same share is taken, to
    one tile: the share of a pair of groups that is no whole number of tiles is rounded up or down
    at random so that its mean holds. Increasing.
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


def pair_statistics(
    bits: npt.NDArray[np.uint64],
    n_directions: int,
    positions: npt.NDArray[np.float32],
    normals: npt.NDArray[np.float32],
    group: npt.NDArray[np.int32],
    d_edges: npt.ArrayLike,
    theta_edges_deg: npt.ArrayLike,
    *,
    tiles: npt.ArrayLike | None = None,
    tile: int = TILE,
    d_near: float | None = None,
    domain: Domain = "sphere",
    directions: npt.NDArray[np.float32] | None = None,
    min_bits: int = 1,
    undefined: Undefined = "skip",
    n_groups: int | None = None,
    threads: int | None = None,
    isa: str | None = None,
    skip_dead: bool = True,
    progress: Progress = False,
) -> PairTable:
    """Sums of ρ over all pairs of points, or those of some tiles (VisMap Sec. 4.1).

    ρ is the Pearson correlation of two rows of bits, (T·n11 − n1·n2)/(√(n1(T − n1)) √(n2(T − n2))),
    from exact integers. d² = (x² + y²) + z² of the difference of positions in float32 lies at or
    past an edge if it is >= the edge's square in float64. The angle does likewise by the squared
    chord `|n − n'|²` and 4 sin²(edge/2), which is exact to 1e-5 degrees below 179.

    Parameters
    ----------
    bits : (N, W) uint64
        Rows of bits; direction k is bit k % 64 of word k // 64, 1 = visible, bits past
        n_directions 0.
    n_directions : int
        T, at most 46340.
    positions, normals : (N, 3) float32
        Scene units; unit vectors.
    group : (N,) int32
        Spatial group of every point, never decreasing. Points of a group must be in random order
        where tiles are chosen.
    d_edges, theta_edges_deg : (D + 1,), (A + 1,)
        Increasing; half-open bins. Pairs outside are not counted. The last d may be infinite, an
        angle of 180 closes its bin.
    tiles : (K,) int, optional
        Numbers of tiles in `tile_list(group, tile)`; all where None.
    tile : int
        Points along a tile's edge, at most, as in `tile_list`.
    d_near : float, optional
        An edge of d: only pairs at or past it are counted, since `near_pairs` counts the others.
    domain : {"sphere", "joint", "union"}
        Directions over which ρ is taken: all; those above the planes of both points; of either.
        A point sees nothing below its own plane where this is not the sphere.
    directions : (T, 3) float32
        Needed for "joint" and "union".
    min_bits : int
        A row with fewer bits set has no ρ, and one with all bits set has none.
    undefined : {"skip", "one_if_both"}
        A pair with such a row is counted in n_undefined; "one_if_both": ρ = 1 where both rows have
        too few bits, or both have all.
    n_groups : int, optional
        Highest group + 1 where None.
    threads : int, optional
        All cores where None.
    isa : {"portable", "avx2", "avx512"}, optional
        Variant of the kernels; the best where None. Without effect on the result.
    skip_dead : bool
        Leave out directions that no point of one side sees. Without effect on the result.
    progress : bool or callable
        A bar, or a function of (pairs done, all pairs).

    Raises
    ------
    ValueError
        An argument that is out of range, with what must hold and what was given.
    """
    edges, angles = _edges(d_edges, "d_edges"), _edges(theta_edges_deg, "theta_edges_deg")
    groups = _groups(group) if n_groups is None else n_groups
    skipped = 0 if d_near is None else _edge_number(edges, d_near)
    require(skipped < len(edges) - 1, "d_near must leave a bin past it", d_near)
    rows = _rows(bits, n_directions, positions, normals, group, groups, domain, directions,
                 min_bits, undefined)  # fmt: skip
    chosen = None if tiles is None else _tile_numbers(tiles)
    with progress_bar(progress, unit="pair") as report:
        sums = _core.correlation.pair_statistics(
            rows, edges[skipped:].tolist(), angles.tolist(), chosen, _tile(tile),
            threads=_threads(threads), isa=isa, skip_dead=skip_dead, progress=report,
        )  # fmt: skip
    return _table(sums, edges, angles, skipped)


def near_pairs(
    bits: npt.NDArray[np.uint64],
    n_directions: int,
    positions: npt.NDArray[np.float32],
    normals: npt.NDArray[np.float32],
    group: npt.NDArray[np.int32],
    d_edges: npt.ArrayLike,
    theta_edges_deg: npt.ArrayLike,
    *,
    d_near: float,
    domain: Domain = "sphere",
    directions: npt.NDArray[np.float32] | None = None,
    min_bits: int = 1,
    undefined: Undefined = "skip",
    n_groups: int | None = None,
    threads: int | None = None,
    isa: str | None = None,
    progress: Progress = False,
) -> PairTable:
    """Sums of ρ over all pairs nearer than `d_near`, an edge of d, found with a uniform grid.

    Random pairs are hardly ever near: bins of small d need all there are. Parameters are those of
    `pair_statistics`; the bins past d_near stay empty.
    """
    edges, angles = _edges(d_edges, "d_edges"), _edges(theta_edges_deg, "theta_edges_deg")
    groups = _groups(group) if n_groups is None else n_groups
    last = _edge_number(edges, d_near)
    require(last > 0, "d_near must leave a bin before it", d_near)
    rows = _rows(bits, n_directions, positions, normals, group, groups, domain, directions,
                 min_bits, undefined)  # fmt: skip
    with progress_bar(progress, unit="point") as report:
        sums = _core.correlation.near_pairs(
            rows, edges[: last + 1].tolist(), angles.tolist(), threads=_threads(threads), isa=isa,
            progress=report,
        )  # fmt: skip
    return _table(sums, edges, angles, 0)


def spatial_map(
    bits: npt.NDArray[np.uint64],
    positions: npt.NDArray[np.float32],
    normals: npt.NDArray[np.float32],
    d_max: float,
    theta_max_deg: float,
    *,
    n_directions: int | None = None,
    min_bits: int = 1,
    undefined: Undefined = "skip",
    threads: int | None = None,
    progress: Progress = False,
) -> npt.NDArray[np.float32]:
    """Mean ρ of every point with its neighbours.

    Neighbours are the other points with d < d_max whose normals differ by less than theta_max_deg.

    Returns
    -------
    (N,) float32
        NaN where a point has no ρ with any neighbour.
    """
    if n_directions is None:
        n_directions = 64 * bits.shape[-1]
    rows = _rows(bits, n_directions, positions, normals, np.zeros(len(bits), np.int32), 1,
                 "sphere", None, min_bits, undefined)  # fmt: skip
    with progress_bar(progress, unit="point") as report:
        return _core.correlation.spatial_map(
            rows, d_max, theta_max_deg, threads=_threads(threads), progress=report
        )


def intersections(
    bits_a: npt.NDArray[np.uint64],
    bits_b: npt.NDArray[np.uint64],
    *,
    threads: int | None = None,
    isa: str | None = None,
) -> npt.NDArray[np.int32]:
    """n11, the number of bits set in both rows, of every row of a with every row of b.

    Parameters
    ----------
    bits_a, bits_b : (NA, W), (NB, W) uint64
    threads : int, optional
        All cores where None.
    isa : {"portable", "avx2", "avx512"}, optional
        Variant of the kernels; the best where None. Without effect on the result.

    Returns
    -------
    (NA, NB) int32
    """
    a, b = _bits(bits_a, "bits_a"), _bits(bits_b, "bits_b")
    return _core.correlation.intersections(a, b, threads=_threads(threads), isa=isa)


def phi(
    bits_a: npt.NDArray[np.uint64],
    bits_b: npt.NDArray[np.uint64],
    n_directions: int,
    *,
    threads: int | None = None,
) -> npt.NDArray[np.float32]:
    """ρ of every row of a with every row of b; see `pair_statistics`.

    Returns
    -------
    (NA, NB) float32
        NaN where all bits of a row are equal.
    """
    a, b = _bits(bits_a, "bits_a"), _bits(bits_b, "bits_b")
    fits = is_whole(n_directions) and 1 <= n_directions <= 64 * a.shape[1]
    require(fits, f"n_directions must be a whole number in [1, {64 * a.shape[1]}]", n_directions)
    n1, n2 = (np.bitwise_count(x).sum(axis=1, dtype=np.int64) for x in (a, b))
    n11 = intersections(a, b, threads=threads).astype(np.int64)
    numerator = n_directions * n11 - n1[:, None] * n2
    spread = [np.sqrt(n * (n_directions - n).astype(np.float64)) for n in (n1, n2)]
    with np.errstate(divide="ignore", invalid="ignore"):
        rho: npt.NDArray[np.float64] = numerator / (spread[0][:, None] * spread[1])
    return rho.astype(np.float32)


def _rows(
    bits: npt.NDArray[np.uint64], n_directions: int, positions: Any, normals: Any, group: Any,
    n_groups: int, domain: str, directions: Any, min_bits: int, undefined: str,
) -> Any:  # fmt: skip
    known = undefined in ("skip", "one_if_both")
    require(known, "undefined must be skip or one_if_both", undefined)
    require(domain == "sphere" or directions is not None,
            "directions must be given unless domain is sphere", directions)  # fmt: skip
    if directions is None or domain == "sphere":
        directions = np.zeros((0, 3), np.float32)
    return _core.correlation.PairRows(
        _bits(bits, "bits"), n_directions, positions, normals, group, n_groups, domain, directions,
        min_bits, undefined == "one_if_both",
    )  # fmt: skip


def _bits(bits: npt.NDArray[np.uint64], name: str) -> npt.NDArray[np.uint64]:
    array = np.asarray(bits)
    require(array.dtype == np.uint64, f"{name} must be uint64", array.dtype)
    return array


def _groups(group: npt.NDArray[np.int32]) -> int:
    return int(np.max(group, initial=0)) + 1


def _tile(tile: int) -> int:
    require(is_whole(tile) and tile >= 1, "tile must be a whole number >= 1", tile)
    return int(tile)


def _tile_numbers(tiles: npt.ArrayLike) -> list[int]:
    numbers = np.asarray(tiles)
    fits = numbers.ndim == 1 and (numbers.size == 0 or np.issubdtype(numbers.dtype, np.integer))
    require(fits, "tiles must be a list of whole numbers", tiles)
    require(bool((numbers >= 0).all()), "tiles must be >= 0", tiles)
    found: list[int] = numbers.tolist()
    return found


def _threads(threads: int | None) -> int:
    fits = threads is None or (is_whole(threads) and threads >= 1)
    require(fits, "threads must be a whole number >= 1 or None", threads)
    return 0 if threads is None else int(threads)


def _edges(edges: npt.ArrayLike, name: str) -> Floats:
    array = np.array(edges, dtype=np.float64)
    fits = array.ndim == 1 and len(array) >= 2
    require(fits, f"{name} must be one-dimensional with two edges or more", array.shape)
    return array


def _edge_number(edges: Floats, d: float) -> int:
    found = np.flatnonzero(edges == d)
    require(len(found) == 1, "d_near must be one of d_edges", d)
    return int(found[0])


def _table(sums: dict[str, Ints], edges: Floats, angles: Floats, first: int) -> PairTable:
    """A table over all edges of d from sums over those from number `first` on."""
    shape = (len(sums["n"]), len(edges) - 1, len(angles) - 1)
    bins = sums["n"].shape[1]
    if bins == shape[1]:
        return PairTable(**sums, d_edges=edges, theta_edges_deg=angles)
    whole = {name: np.zeros(shape, np.int64) for name in SUMS}
    for name in SUMS:
        whole[name][:, first : first + bins] = sums[name]
    return PairTable(**whole, d_edges=edges, theta_edges_deg=angles)

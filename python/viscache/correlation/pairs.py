"""Statistics of ρ over pairs of points, from their rows of bits.

Every pair adds q = round(ρ·2²⁰) and q² to the cell of its two groups, its distance and its angle.
The sums are integers, so tables of parts of the pairs add up to the same bytes in any order, with
any number of threads and any instruction set.
"""

from __future__ import annotations

from typing import Any, Literal, TypeAlias

import numpy as np
import numpy.typing as npt

from viscache import _core
from viscache.base.progress import Progress, progress_bar
from viscache.correlation.pair_table import SUMS, Floats, Ints, PairTable
from viscache.correlation.pair_tiles import (
    TILE,
    choose_tiles,
    group_count,
    tile_list,
    tile_numbers,
    tile_side,
)
from viscache.settings.checks import checked_floats, checked_threads, is_whole, require

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

Domain: TypeAlias = Literal["sphere", "joint", "union"]
Undefined: TypeAlias = Literal["skip", "one_if_both"]

#: q = round(ρ·SCALE).
SCALE = 1 << 20


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
    """Sums of ρ over all pairs of points, or over the pairs of some tiles (VisMap Sec. 4.1).

    ρ is the Pearson correlation of two rows of bits, (T·n11 − n1·n2)/(√(n1(T − n1)) √(n2(T − n2))),
    from exact integers. A pair is at or past an edge of d if d² = (x² + y²) + z², computed in
    float32 from the difference of positions, is >= the square of the edge in float64. For the
    angle, the squared chord `|n − n'|²` is compared with 4 sin²(edge/2), which is exact to 1e-5
    degrees below 179.

    Parameters
    ----------
    bits : (N, W) uint64
        Rows of bits: direction k is bit k % 64 of word k // 64; 1 = visible. Bits past n_directions
        are 0.
    n_directions : int
        T, at most 46340.
    positions, normals : (N, 3) float32
        Positions in scene units; unit normals.
    group : (N,) int32
        Spatial group of every point, not decreasing. If tiles are chosen, the points of a group
        must be in random order.
    d_edges, theta_edges_deg : (D + 1,), (A + 1,)
        Increasing edges of half-open bins. Pairs outside are not counted. The last d may be
        infinite; an angle of 180 is included in the last bin.
    tiles : (K,) int, optional
        Numbers of tiles in `tile_list(group, tile)`; None: all.
    tile : int
        Maximum number of points along the edge of a tile, as in `tile_list`.
    d_near : float, optional
        An edge of d. Only pairs at or past it are counted; `near_pairs` counts the others.
    domain : {"sphere", "joint", "union"}
        Directions over which ρ is taken: all; those above the tangent planes of both points; those
        above at least one. Except for "sphere", bits below a point's own plane count as 0.
    directions : (T, 3) float32
        Required for "joint" and "union".
    min_bits : int
        A row with fewer set bits has no ρ; a row with all bits set has none either.
    undefined : {"skip", "one_if_both"}
        A pair with such a row is counted in n_undefined. "one_if_both": ρ = 1 if both rows have too
        few bits, or both have all bits set.
    n_groups : int, optional
        None: highest group + 1.
    threads : int, optional
        All cores by default.
    isa : {"portable", "avx2", "avx512"}, optional
        Variant of the kernels; the best one by default. It does not change the result.
    skip_dead : bool
        Skip directions that no point of one side sees. Does not change the result.
    progress : bool or callable
        True shows a progress bar; a callable is called with (done, total) pairs.

    Raises
    ------
    ValueError
        An argument is out of range; the message says what must hold and what was given.
    """
    edges, angles = _edges(d_edges, "d_edges"), _edges(theta_edges_deg, "theta_edges_deg")
    groups = group_count(group) if n_groups is None else n_groups
    skipped = 0 if d_near is None else _edge_number(edges, d_near)
    require(skipped < len(edges) - 1, "d_near must leave a bin past it", d_near)
    points = (positions, normals, group, groups)
    rows = _rows(bits, n_directions, *points, domain, directions, min_bits, undefined)
    chosen = None if tiles is None else tile_numbers(tiles)
    with progress_bar(progress, unit="pair") as report:
        sums = _core.correlation.pair_statistics(
            rows,
            edges[skipped:].tolist(),
            angles.tolist(),
            chosen,
            tile_side(tile),
            threads=checked_threads(threads),
            isa=isa,
            skip_dead=skip_dead,
            progress=report,
        )
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
    """Sums of ρ over all pairs nearer than `d_near`, an edge of d.

    Random pairs are rarely near, so bins of small d need all pairs. They are found with a uniform
    grid. Parameters are those of `pair_statistics`; the bins past d_near stay empty.
    """
    edges, angles = _edges(d_edges, "d_edges"), _edges(theta_edges_deg, "theta_edges_deg")
    groups = group_count(group) if n_groups is None else n_groups
    last = _edge_number(edges, d_near)
    require(last > 0, "d_near must leave a bin before it", d_near)
    points = (positions, normals, group, groups)
    rows = _rows(bits, n_directions, *points, domain, directions, min_bits, undefined)
    with progress_bar(progress, unit="point") as report:
        sums = _core.correlation.near_pairs(
            rows,
            edges[: last + 1].tolist(),
            angles.tolist(),
            threads=checked_threads(threads),
            isa=isa,
            progress=report,
        )
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
        NaN if a point has no ρ with any neighbour.
    """
    if n_directions is None:
        n_directions = 64 * bits.shape[-1]
    points = (positions, normals, np.zeros(len(bits), np.int32), 1)
    rows = _rows(bits, n_directions, *points, "sphere", None, min_bits, undefined)
    with progress_bar(progress, unit="point") as report:
        return _core.correlation.spatial_map(
            rows, d_max, theta_max_deg, threads=checked_threads(threads), progress=report
        )


def intersections(
    bits_a: npt.NDArray[np.uint64],
    bits_b: npt.NDArray[np.uint64],
    *,
    threads: int | None = None,
    isa: str | None = None,
) -> npt.NDArray[np.int32]:
    """n11, the number of bits set in both rows, for every row of a with every row of b.

    Parameters
    ----------
    bits_a, bits_b : (NA, W), (NB, W) uint64
    threads : int, optional
        All cores by default.
    isa : {"portable", "avx2", "avx512"}, optional
        Variant of the kernels; the best one by default. It does not change the result.

    Returns
    -------
    (NA, NB) int32
    """
    a, b = _bits(bits_a, "bits_a"), _bits(bits_b, "bits_b")
    return _core.correlation.intersections(a, b, threads=checked_threads(threads), isa=isa)


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
        NaN if all bits of a row are equal.
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
    bits: npt.NDArray[np.uint64],
    n_directions: int,
    positions: Any,
    normals: Any,
    group: Any,
    n_groups: int,
    domain: str,
    directions: Any,
    min_bits: int,
    undefined: str,
) -> Any:
    known = undefined in ("skip", "one_if_both")
    require(known, "undefined must be skip or one_if_both", undefined)
    fits = domain == "sphere" or directions is not None
    require(fits, "directions must be given unless domain is sphere", directions)
    if directions is None or domain == "sphere":
        directions = np.zeros((0, 3), np.float32)
    words, both = _bits(bits, "bits"), undefined == "one_if_both"
    points = (positions, normals, group, n_groups)
    return _core.correlation.PairRows(
        words, n_directions, *points, domain, directions, min_bits, both
    )


def _bits(bits: npt.NDArray[np.uint64], name: str) -> npt.NDArray[np.uint64]:
    array = np.asarray(bits)
    require(array.dtype == np.uint64, f"{name} must be uint64", array.dtype)
    return array


def _edges(edges: npt.ArrayLike, name: str) -> Floats:
    array = np.array(checked_floats(edges, name, np.float64))
    fits = array.ndim == 1 and len(array) >= 2
    require(fits, f"{name} must be one-dimensional with two edges or more", array.shape)
    return array


def _edge_number(edges: Floats, d: float) -> int:
    found = np.flatnonzero(edges == d)
    require(len(found) == 1, "d_near must be one of d_edges", d)
    return int(found[0])


def _table(sums: dict[str, Ints], edges: Floats, angles: Floats, first: int) -> PairTable:
    """A table over all edges of d from sums over the edges from index `first` on."""
    shape = (len(sums["n"]), len(edges) - 1, len(angles) - 1)
    bins = sums["n"].shape[1]
    if bins == shape[1]:
        return PairTable(**sums, d_edges=edges, theta_edges_deg=angles)
    whole = {name: np.zeros(shape, np.int64) for name in SUMS}
    for name in SUMS:
        whole[name][:, first : first + bins] = sums[name]
    return PairTable(**whole, d_edges=edges, theta_edges_deg=angles)

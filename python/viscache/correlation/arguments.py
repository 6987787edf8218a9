"""Validates and converts the arguments of `measure` and `correlate`."""

from __future__ import annotations

import hashlib
from typing import Any, Literal, TypeAlias

import numpy as np
import numpy.typing as npt

from viscache.correlation import rows as _rows
from viscache.correlation.bins import Bins, checked_edges, linear_bins, pilot_d_max
from viscache.correlation.pairs import Domain, Undefined
from viscache.correlation.tasks import PairOptions, Points
from viscache.correlation.work import tile_size
from viscache.settings.checks import checked_floats, is_whole, require

Edges: TypeAlias = "int | npt.ArrayLike"
Words: TypeAlias = npt.NDArray[np.uint64]

DOMAINS = ("sphere", "joint", "union")
UNDEFINED = ("skip", "one_if_both")
#: Each pair of groups has its own table, so their number is limited.
MAX_GROUPS = 32


def check_seed(seed: int) -> None:
    require(is_whole(seed) and 0 <= seed < 1 << 63, "seed must be in [0, 2^63)", seed)


def checked_words(
    bits: npt.ArrayLike, name: str, n_directions: int | None = None
) -> tuple[Words, int]:
    """Rows (N, W) with W a multiple of 8, and the number of directions (all bits by default)."""
    array = np.asarray(bits)
    fits = array.ndim == 2 and array.dtype == np.uint64 and array.shape[1] >= 1
    require(fits, f"{name} must be uint64 of shape (N, W)", f"{array.dtype} {array.shape}")
    most = 64 * array.shape[1]
    count = most if n_directions is None else n_directions
    fits = is_whole(count) and 1 <= count <= most
    require(fits, f"n_directions must be a whole number in [1, {most}]", n_directions)
    unused = np.full(array.shape[1], ~np.uint64(0))
    unused[: count // 64] = 0
    if count % 64:
        unused[count // 64] <<= np.uint64(count % 64)
    if unused.any():
        stray = np.flatnonzero((array & unused).any(axis=1))
        require(not stray.size, f"{name} from n_directions = {count} on must be 0", stray[:1])
    padding = -array.shape[1] % 8
    return np.ascontiguousarray(np.pad(array, ((0, 0), (0, padding)))), int(count)


def checked_rows(
    bits: npt.ArrayLike,
    n_directions: int | None,
    positions: npt.ArrayLike,
    normals: npt.ArrayLike,
    group: npt.ArrayLike | None,
) -> tuple[Words, int, Points]:
    """Rows and points sorted by group, and the number of directions."""
    rows, count = checked_words(bits, "bits", n_directions)
    places, directions = checked_floats(positions, "positions"), checked_floats(normals, "normals")
    for name, array in (("positions", places), ("normals", directions)):
        fits = array.shape == (len(rows), 3)
        require(fits, f"{name} must have shape ({len(rows)}, 3)", array.shape)
        require(bool(np.isfinite(array).all()), f"{name} must be finite", name)
    require(len(rows) >= 2, "bits must have at least 2 rows", len(rows))
    labels = _rows.spatial_groups(places) if group is None else np.asarray(group)
    fits = labels.shape == (len(rows),) and labels.dtype.kind in "iu" and bool((labels >= 0).all())
    require(fits, f"group must be {len(rows)} whole numbers >= 0", labels.shape)
    known, labels = np.unique(labels, return_inverse=True)
    require(len(known) <= MAX_GROUPS, f"group must have at most {MAX_GROUPS} values", len(known))
    order = np.argsort(labels, kind="stable")
    points = Points(
        positions=places[order], normals=directions[order], group=labels[order].astype(np.int32)
    )
    return rows[order], count, points


def chosen_bins(
    positions: npt.NDArray[np.float32],
    d_edges: Edges,
    theta_edges_deg: Edges,
    slices: tuple[float, float],
    *,
    d_max: float | None,
    seed: int,
) -> Bins:
    """Bins from given edges, or from given numbers of evenly spaced bins.

    `slices` is (slice_d, slice_theta_deg).
    """
    slice_d, slice_theta_deg = slices
    fits = d_max is None or isinstance(d_edges, int)
    require(fits, "d_max must be left out with edges of d", d_max)
    end, even = d_max, 1.0
    if isinstance(d_edges, int):
        end = even = pilot_d_max(positions, seed) if d_max is None else float(d_max)
    spread = linear_bins(
        even,
        d_edges if isinstance(d_edges, int) else 1,
        theta_edges_deg if isinstance(theta_edges_deg, int) else 1,
    )
    return Bins(
        d_edges=spread.d_edges if isinstance(d_edges, int) else checked_edges(d_edges, "d_edges"),
        theta_edges_deg=spread.theta_edges_deg
        if isinstance(theta_edges_deg, int)
        else checked_edges(theta_edges_deg, "theta_edges_deg"),
        slice_d=slice_d,
        slice_theta_deg=slice_theta_deg,
        d_end=end,
    )


def sampled_pairs(pairs: Literal["all"] | int, n_points: int) -> int | None:
    """Number of pairs to sample; None for all pairs."""
    if pairs == "all":
        return None
    fits = is_whole(pairs) and int(pairs) >= 1
    require(fits, 'pairs must be "all" or a whole number >= 1', pairs)
    return int(pairs) if int(pairs) < n_points * (n_points - 1) // 2 else None


def pair_options(
    points: Points,
    bins: Bins,
    n_directions: int,
    undefined: Undefined,
    min_bits: int,
    *,
    sampled: bool,
    domain: Domain = "sphere",
    directions: Any = None,
) -> PairOptions:
    """Options for counting pairs."""
    require(domain in DOMAINS, f"domain must be one of {DOMAINS}", domain)
    require(undefined in UNDEFINED, f"undefined must be one of {UNDEFINED}", undefined)
    require(is_whole(min_bits) and min_bits >= 1, "min_bits must be a whole number >= 1", min_bits)
    return PairOptions(
        n_directions=n_directions,
        d_cells=bins.d_cells,
        theta_cells=bins.theta_cells,
        domain=domain,
        directions=directions,
        undefined=undefined,
        min_bits=int(min_bits),
        tile=tile_size(points.group, sampled),
    )


def digest(*arrays: npt.NDArray[Any]) -> str:
    found = hashlib.sha256()
    for array in arrays:
        found.update(f"{array.dtype} {array.shape}".encode())
        found.update(np.ascontiguousarray(array).data)
    return found.hexdigest()

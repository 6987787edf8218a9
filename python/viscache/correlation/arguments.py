"""Validates and converts the arguments of `measure` and `correlate`."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from typing import Any, Literal, TypeAlias, TypedDict, get_args

import numpy as np
import numpy.typing as npt

from viscache import _core
from viscache.correlation import rows as _rows
from viscache.correlation.bins import N_D, N_THETA, Bins, checked_edges, linear_bins, pilot_d_max
from viscache.correlation.pairs import Domain, Undefined
from viscache.correlation.rows import RowEngine
from viscache.correlation.tasks import PairOptions, Points
from viscache.correlation.work import tile_size
from viscache.settings.checks import checked_floats, is_number, is_whole, require

Edges: TypeAlias = "int | npt.ArrayLike"
Words: TypeAlias = npt.NDArray[np.uint64]

#: Each pair of groups has its own table, so their number is limited.
MAX_GROUPS = 32


class PairKeywords(TypedDict, total=False):
    """Keywords of `correlate` and `measure`; `measure` explains them."""

    pairs: Literal["all"] | int
    seed: int
    d_edges: Edges
    theta_edges_deg: Edges
    d_max: float | None
    slice_d: float
    slice_theta_deg: float
    undefined: Undefined
    min_bits: int
    threads: int | None


class MeasureKeywords(PairKeywords, total=False):
    """Further keywords of `measure`."""

    n_points: int
    map_size: int
    points: Literal["camera", "area"] | None
    camera: str | int | _core.Camera | None
    directions: Literal["centres", "jittered", "lloyd"]
    domain: Domain
    normals: Literal["geometric", "shading"]
    t_max: float | Literal["auto"]
    engine: RowEngine


@dataclass(frozen=True, kw_only=True, eq=False)
class PairSettings:
    """Which pairs are counted, and in which bins."""

    pairs: Literal["all"] | int = "all"
    seed: int = 0
    d_edges: Edges = N_D
    theta_edges_deg: Edges = N_THETA
    d_max: float | None = None
    slice_d: float = 0.2
    slice_theta_deg: float = 2.0
    undefined: Undefined = "skip"
    min_bits: int = 1
    domain: Domain = "sphere"
    threads: int | None = None

    def __post_init__(self) -> None:
        fits = is_whole(self.seed) and 0 <= self.seed < 1 << 63
        require(fits, "seed must be in [0, 2^63)", self.seed)
        known = get_args(Undefined)
        require(self.undefined in known, f"undefined must be one of {known}", self.undefined)
        fits = is_whole(self.min_bits) and self.min_bits >= 1
        require(fits, "min_bits must be a whole number >= 1", self.min_bits)
        domains = get_args(Domain)
        require(self.domain in domains, f"domain must be one of {domains}", self.domain)

    def bins(self, positions: npt.NDArray[np.float32]) -> Bins:
        """Bins from given edges, or from given numbers of evenly spaced bins."""
        d, theta = self.d_edges, self.theta_edges_deg
        fits = self.d_max is None or isinstance(d, int)
        require(fits, "d_max must be left out with edges of d", self.d_max)
        end, even = self.d_max, 1.0
        if isinstance(d, int):
            end = even = pilot_d_max(positions, self.seed) if end is None else float(end)
        spread = linear_bins(
            even, d if isinstance(d, int) else 1, theta if isinstance(theta, int) else 1
        )
        return Bins(
            d_edges=spread.d_edges if isinstance(d, int) else checked_edges(d, "d_edges"),
            theta_edges_deg=spread.theta_edges_deg
            if isinstance(theta, int)
            else checked_edges(theta, "theta_edges_deg"),
            slice_d=self.slice_d,
            slice_theta_deg=self.slice_theta_deg,
            d_end=end,
        )

    def sampled(self, n_points: int) -> int | None:
        """Number of pairs to sample; None for all pairs."""
        if self.pairs == "all":
            return None
        fits = is_whole(self.pairs) and int(self.pairs) >= 1
        require(fits, 'pairs must be "all" or a whole number >= 1', self.pairs)
        return int(self.pairs) if int(self.pairs) < n_points * (n_points - 1) // 2 else None

    def pair_options(
        self, points: Points, bins: Bins, n_directions: int, directions: Any = None
    ) -> PairOptions:
        """Options for counting pairs."""
        return PairOptions(
            n_directions=n_directions,
            d_cells=bins.d_cells,
            theta_cells=bins.theta_cells,
            domain=self.domain,
            directions=directions,
            undefined=self.undefined,
            min_bits=int(self.min_bits),
            tile=tile_size(points.group, self.sampled(len(points.group)) is not None),
        )


@dataclass(frozen=True, kw_only=True, eq=False)
class MeasureSettings(PairSettings):
    """Also which points there are, and how their rows are traced."""

    n_points: int = 20_000
    map_size: int = 96
    points: Literal["camera", "area"] | None = None
    camera: str | int | _core.Camera | None = None
    directions: Literal["centres", "jittered", "lloyd"] = "centres"
    normals: Literal["geometric", "shading"] = "geometric"
    t_max: float | Literal["auto"] = "auto"
    engine: RowEngine = "embree"

    def __post_init__(self) -> None:
        super().__post_init__()
        reach = self.t_max
        fits = reach == "auto" if isinstance(reach, str) else is_number(reach) and reach > 0
        require(fits, 't_max must be > 0 or "auto"', reach)
        fits = self.domain == "sphere" or self.normals == "geometric"
        require(fits, 'domain must be "sphere" with shading normals', self.domain)
        fits = self.engine in get_args(RowEngine)
        require(fits, 'engine must be "embree", "batch", "field" or "auto"', self.engine)


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


def digest(*arrays: npt.NDArray[Any]) -> str:
    found = hashlib.sha256()
    for array in arrays:
        found.update(f"{array.dtype} {array.shape}".encode())
        found.update(np.ascontiguousarray(array).data)
    return found.hexdigest()

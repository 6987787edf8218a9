"""The two ends of connections as arrays: eye points and far ends."""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from typing import Any, Literal, TypeAlias

import numpy as np
import numpy.typing as npt

from viscache.settings.aqvc import LIGHT_GROUPS
from viscache.settings.checks import checked_floats, is_number, require
from viscache.settings.spelling import spelled

Array: TypeAlias = npt.NDArray[Any]
Kind: TypeAlias = Literal["points", "directions", "surfaces", "solid_angle"]

#: Number of neighbours for the density of points, if none is given.
NEIGHBOURS = 8
#: Number of points per search for neighbours.
QUERY_POINTS = 1 << 14
GROUP_OF_KIND = {
    "points": "point",
    "directions": "directional",
    "surfaces": "vpl",
    "solid_angle": "environment",
}


def rows3(values: Any, name: str) -> npt.NDArray[np.float32]:
    """An (N, 3) array of finite floats; the error names what was given."""
    rows = checked_floats(values, name)
    require(rows.ndim == 2 and rows.shape[1] == 3, f"{name} must have shape (N, 3)", rows.shape)
    bad = np.flatnonzero(~np.isfinite(rows).all(axis=1))
    if bad.size:
        raise ValueError(f"{name} must be finite, row {bad[0]} is {rows[bad[0]]}")
    return rows


def units(values: Any, name: str) -> npt.NDArray[np.float32]:
    """An (N, 3) array of directions, scaled to length 1."""
    rows = rows3(values, name)
    lengths = np.linalg.norm(rows.astype(np.float64), axis=1)
    bad = np.flatnonzero(lengths == 0)
    if bad.size:
        raise ValueError(f"{name} must not be zero, row {bad[0]} is {rows[bad[0]]}")
    if np.all(np.abs(lengths - 1) < 1e-4):
        return rows
    scaled: npt.NDArray[np.float32] = (rows / lengths[:, None]).astype(np.float32)
    return scaled


def densities(values: Any, count: int) -> npt.NDArray[np.float32] | None:
    """One density per row; a number is for all rows."""
    if values is None:
        return None
    given = checked_floats(values, "density")
    require(
        given.shape in ((), (count,)),
        f"density must be a number or have shape ({count},)",
        given.shape,
    )
    good = bool(np.all(np.isfinite(given) & (given >= 0)))
    require(good, "density must be finite and >= 0", values)
    return np.ascontiguousarray(np.broadcast_to(given, (count,)))


def neighbour_density(positions: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
    """Points per unit area from the distance r to the k-th nearest neighbour: k/(π r²).

    k is 8, or less if there are fewer points. A point without neighbours has density 0, which gives
    the coarsest cells. If k points coincide, they get the largest finite density of the set.
    """
    from scipy.spatial import cKDTree

    k = min(NEIGHBOURS, len(positions) - 1)
    if k < 1:
        return np.zeros(len(positions), dtype=np.float32)
    places = positions.astype(np.float64)
    tree = cKDTree(places)

    def spacing(first: int) -> Array:
        nearest: Array = tree.query(places[first : first + QUERY_POINTS], k=[k + 1])[0]
        return nearest[:, 0]

    # Small pieces, so that Ctrl-C ends it soon and leaves no thread behind
    with ThreadPoolExecutor(len(os.sched_getaffinity(0))) as pool:
        pieces = [pool.submit(spacing, i) for i in range(0, len(places), QUERY_POINTS)]
        try:
            distance = np.concatenate([piece.result() for piece in pieces])
        except BaseException:
            pool.shutdown(wait=True, cancel_futures=True)
            raise
    with np.errstate(divide="ignore"):
        density = k / (np.pi * distance**2)
    finite = density[np.isfinite(density)]
    most = finite.max() if finite.size else 0.0
    bounded: npt.NDArray[np.float32] = np.minimum(density, most).astype(np.float32)
    return bounded


@spelled
@dataclass(frozen=True, eq=False)
class EyePoints:
    """Points on surfaces, of any source, from which visibility is asked.

    Parameters
    ----------
    positions : (N, 3) float
        On the surfaces, scene units, finite.
    normals : (N, 3) float
        Geometric normals on the side of the connections; scaled to length 1. Rays start on that
        side, a few units in the last place above the surface.
    density : float or (N,) float, optional
        Eye points per unit area, which determine the cell sizes of the quantized cache. By default
        computed from the distance to the 8th nearest neighbour, when a cache needs it.

    Raises
    ------
    ValueError
        Shapes that do not fit, values that are not finite.

    Examples
    --------
    >>> import viscache as vc
    >>> eyes = vc.EyePoints([(0, 0, 0), (1, 0, 0)], [(0, 1, 0), (0, 2, 0)])
    >>> len(eyes), eyes[:1].normals.tolist()
    (2, [[0.0, 1.0, 0.0]])
    """

    positions: Array
    normals: Array
    density: Array | float | None = None
    _origins: Array | None = field(default=None, repr=False)  #: where rays start, if known
    _tiles: tuple[dict[str, Any], ...] | None = field(default=None, repr=False)  #: of a frame
    _tracer: Callable[..., Array] | None = field(default=None, repr=False)

    def __post_init__(self) -> None:
        set_value = object.__setattr__
        set_value(self, "positions", rows3(self.positions, "positions"))
        set_value(self, "normals", units(self.normals, "normals"))
        require(
            len(self.normals) == len(self.positions),
            f"normals must have {len(self.positions)} rows",
            len(self.normals),
        )
        set_value(self, "density", densities(self.density, len(self.positions)))

    def __len__(self) -> int:
        return len(self.positions)

    def __getitem__(self, rows: Any) -> EyePoints:
        """Some of the points: a slice, a mask or indices."""
        rows = [rows] if isinstance(rows, int | np.integer) else rows
        density = None if self.density is None else np.asarray(self.density)[rows]
        origins = None if self._origins is None else self._origins[rows]
        return replace(
            self,
            positions=self.positions[rows],
            normals=self.normals[rows],
            density=density,
            _origins=origins,
            _tiles=None,
        )

    def with_density(self) -> EyePoints:
        """The same points with a density: their own, or the neighbours'."""
        if self.density is not None:
            return self
        return replace(self, density=neighbour_density(self.positions))

    def trace(self, ends: FarEnds, wanted: Any = None) -> npt.NDArray[np.bool_]:
        """Trace rays, for oracles written in Python. The frame counts them.

        Parameters
        ----------
        ends : FarEnds
        wanted : (N, M) bool, optional
            Which connections to trace; all by default. The rest is answered False.

        Returns
        -------
        (N, M) bool

        Raises
        ------
        ValueError
            The points are not from a frame. Use `scene.visible_matrix` for other points.
        """
        if self._tracer is None:
            raise ValueError("points must be those that a frame handed to an oracle, got others")
        asked = None if wanted is None else np.asarray(wanted, dtype=bool)
        return unpack(self._tracer(self, ends, asked), len(ends))

    def _arrays(self) -> dict[str, Any]:
        return {
            "positions": self.positions,
            "normals": self.normals,
            "density": self.density,
            "origins": self._origins,
        }


@spelled
@dataclass(frozen=True, eq=False)
class FarEnds:
    """M far ends of connections: points, directions, surface points or directions of a sky.

    Made by `FarEnds.points`, `.directions`, `.surfaces` or `.solid_angle`.

    Attributes
    ----------
    kind : {"points", "directions", "surfaces", "solid_angle"}
        Determines the keys of the quantized cache (AQVC Sec. 3.5).
    positions : (M, 3) float32
        Positions, or unit directions towards the light.
    normals : (M, 3) float32 or None
        Of surfaces.
    density : (M,) float32 or None
        Light samples per unit area of surfaces, per steradian of a sky.
    t_max : float
        Length of rays along directions, scene units.
    group : str
        The light group whose settings hold (c_e_groups, refinement) and whose counters
        count.
    """

    kind: Kind
    positions: Array
    normals: Array | None = None
    density: Array | float | None = None
    t_max: float = float("inf")
    group: str = ""
    _ends: Array | None = field(default=None, repr=False)  #: where rays end, if known

    def __post_init__(self) -> None:
        set_value = object.__setattr__
        require(
            self.kind in GROUP_OF_KIND, f"kind must be one of {', '.join(GROUP_OF_KIND)}", self.kind
        )
        along = self.kind in ("directions", "solid_angle")
        places = (
            units(self.positions, "directions") if along else rows3(self.positions, "positions")
        )
        set_value(self, "positions", places)
        require(len(places) > 0, "there must be a far end", 0)
        if self.normals is not None:
            normals = (units if self.kind == "surfaces" else rows3)(self.normals, "normals")
            require(
                len(normals) == len(places), f"normals must have {len(places)} rows", len(normals)
            )
            set_value(self, "normals", normals)
        set_value(self, "density", densities(self.density, len(places)))
        require(is_number(self.t_max) and self.t_max >= 0, "t_max must be >= 0", self.t_max)
        set_value(self, "group", self.group or GROUP_OF_KIND[self.kind])
        require(
            self.group in LIGHT_GROUPS,
            f"group must be one of {', '.join(LIGHT_GROUPS)}",
            self.group,
        )

    @classmethod
    def points(cls, positions: Any, *, group: str = "point") -> FarEnds:
        """Points in space, (M, 3): lamps, probes, virtual lights keyed as points."""
        return cls("points", positions, group=group)

    @classmethod
    def directions(
        cls, directions: Any, *, t_max: float = float("inf"), group: str = "directional"
    ) -> FarEnds:
        """Directions towards far lights, (M, 3), and the length of rays."""
        return cls("directions", directions, t_max=t_max, group=group)

    @classmethod
    def surfaces(
        cls, positions: Any, normals: Any, density: Any = 0.0, *, group: str = "vpl"
    ) -> FarEnds:
        """Points on surfaces, (M, 3), with normals and samples per unit area."""
        return cls("surfaces", positions, normals, density, group=group)

    @classmethod
    def solid_angle(
        cls,
        directions: Any,
        density: Any,
        *,
        t_max: float = float("inf"),
        group: str = "environment",
    ) -> FarEnds:
        """Directions of a sky, (M, 3), with samples per steradian."""
        return cls("solid_angle", directions, None, density, t_max, group)

    def __len__(self) -> int:
        return len(self.positions)

    def __getitem__(self, rows: Any) -> FarEnds:
        """Some of the far ends: a slice, a mask or indices."""
        rows = [rows] if isinstance(rows, int | np.integer) else rows

        def some(values: Any) -> Any:
            return None if values is None else np.asarray(values)[rows]

        return replace(
            self,
            positions=self.positions[rows],
            normals=some(self.normals),
            density=some(self.density),
            _ends=some(self._ends),
        )

    def _arrays(self) -> dict[str, Any]:
        return {
            "kind": self.kind,
            "group": LIGHT_GROUPS.index(self.group),
            "positions": self.positions,
            "normals": self.normals,
            "ends": self._ends,
            "density": self.density,
            "t_max": self.t_max,
        }


def eyes_of(arrays: dict[str, Any], tracer: Callable[..., Array] | None = None) -> EyePoints:
    """Eye points from the arrays of C++."""
    return EyePoints(
        arrays["positions"],
        arrays["normals"],
        arrays["density"],
        _origins=arrays["origins"],
        _tracer=tracer,
    )


def ends_of(arrays: dict[str, Any]) -> FarEnds:
    """Far ends from the arrays of C++."""
    normals = arrays["normals"] if arrays["kind"] == "surfaces" else None
    return FarEnds(
        arrays["kind"],
        arrays["positions"],
        normals,
        arrays["density"],
        arrays["t_max"],
        LIGHT_GROUPS[arrays["group"]],
        _ends=arrays["ends"],
    )


def pack(visible: npt.NDArray[np.bool_]) -> npt.NDArray[np.uint64]:
    """Rows of bits (N, ⌈M/64⌉) of a bool array (N, M): bit k % 64 of word k // 64."""
    count, columns = visible.shape
    words = -(-columns // 64)
    if columns % 64:
        padded = np.zeros((count, words * 64), dtype=bool)
        padded[:, :columns] = visible
        visible = padded
    packed = np.packbits(visible, axis=1, bitorder="little")
    return packed.view("<u8").astype(np.uint64, copy=False).reshape(count, words)


def unpack(bits: npt.NDArray[np.uint64], columns: int) -> npt.NDArray[np.bool_]:
    """The inverse of `pack`."""
    words = np.ascontiguousarray(bits, dtype="<u8")
    unpacked = np.unpackbits(words.view(np.uint8), axis=1, count=columns, bitorder="little")
    return unpacked.view(np.bool_)


def tiles_of(eyes: EyePoints) -> dict[str, Any] | list[dict[str, Any]]:
    """What `_core.ask_block` takes: one set of arrays, or the tiles of a frame."""
    return eyes._arrays() if eyes._tiles is None else list(eyes._tiles)

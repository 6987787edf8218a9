"""Tasks of a worker: trace the rows of a block of points, count the pairs of a block of groups.

A task holds the file or name of the scene and the folder of the rows, not the scene or the bits. So
it can run in any process with access to the same files.
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from viscache.base.formats import ArrayField, Format
from viscache.base.sharing import Newest
from viscache.correlation import pairs as _pairs
from viscache.correlation import rows as _rows
from viscache.correlation.bins import Floats
from viscache.correlation.pair_table import SUMS
from viscache.correlation.pair_tiles import tile_list
from viscache.correlation.work import PairBlock
from viscache.correlation.work_store import Arrays, mapped_rows
from viscache.scenes import sources


@dataclass(frozen=True, kw_only=True, slots=True)
class Points:
    """The points of rows, sorted by group."""

    positions: npt.NDArray[np.float32]
    normals: npt.NDArray[np.float32]
    """Normals for the angle θ."""
    group: npt.NDArray[np.int32]

    def of_groups(self, groups: list[int]) -> npt.NDArray[np.intp]:
        """Indices of the points of some groups, in order."""
        low = np.searchsorted(self.group, groups, side="left")
        high = np.searchsorted(self.group, groups, side="right")
        return np.concatenate([np.arange(a, b) for a, b in zip(low, high, strict=True)])


@dataclass(frozen=True, kw_only=True, slots=True)
class PairOptions:
    """Options for counting pairs; the same for all blocks."""

    n_directions: int
    d_cells: Floats
    theta_cells: Floats
    domain: _pairs.Domain
    directions: _rows.DirectionSet | None
    """For the domains "joint" and "union"."""
    undefined: _pairs.Undefined
    min_bits: int
    tile: int
    """Maximum number of points along a tile of pairs."""


@dataclass(frozen=True, kw_only=True, slots=True)
class RowsTask:
    """Rows of the points [first, last)."""

    first: int
    last: int
    folder: Path | None
    scene: Any
    scene_hash: str
    directions: _rows.DirectionSet
    t_max: float
    engine: _rows.RowEngine
    threads: int | None


@dataclass(frozen=True, kw_only=True, slots=True)
class PairTask:
    """Pairs of a block of group pairs; with `d_near`, all pairs nearer than that."""

    block: PairBlock
    folder: Path | None
    options: PairOptions
    d_near: float | None
    threads: int | None

    @property
    def name(self) -> str:
        """Name of the block in the store."""
        return "near" if self.d_near is not None else f"pairs-{self.block.index:05d}"


def trace(
    task: RowsTask, scene: Any, positions: npt.NDArray[np.float32], normals: npt.NDArray[np.float32]
) -> Arrays:
    """Trace the rows of a block in this process; positions and normals are those of all points."""
    block = slice(task.first, task.last)
    points = positions[block], normals[block]
    rows = _rows.trace_rows(
        scene, *points, task.directions, t_max=task.t_max, engine=task.engine, threads=task.threads
    )
    return {
        "bits": rows.bits,
        "n_rays": np.array(rows.n_rays),
        "seconds": np.array(rows.seconds),
        "batch_rays": np.array(rows.n_rays if rows.engine == "batch" else 0),
    }


def count(task: PairTask, bits: npt.NDArray[np.uint64], points: Points) -> Arrays:
    """Integer sums over the pairs of a block, computed in this process.

    "pair" (k, 2) are groups, the arrays of `pairs.SUMS` (k, D, T) are of these; "evaluated" is the
    number of pairs before binning.
    """
    began = time.perf_counter()
    options = task.options
    groups = sorted({g for pair in task.block.pairs for g in pair})
    chosen = points.of_groups(groups)
    whole = len(chosen) == len(points.group)
    rows = bits if whole else bits[chosen]
    label = np.searchsorted(groups, points.group[chosen]).astype(np.int32)
    settings: dict[str, Any] = {
        "domain": options.domain,
        "undefined": options.undefined,
        "min_bits": options.min_bits,
        "n_groups": len(groups),
        "threads": task.threads,
    }
    if options.domain != "sphere" and options.directions is not None:
        settings["directions"] = options.directions.directions
    geometry = (points.positions[chosen], points.normals[chosen], label)
    given = (rows, options.n_directions, *geometry)
    if task.d_near is not None:
        kept = options.d_cells <= task.d_near
        table = _pairs.near_pairs(
            *given, options.d_cells[kept], options.theta_cells, d_near=task.d_near, **settings
        )
        evaluated = 0
    else:
        tiles, evaluated = _tiles(task.block, label, groups, options.tile)
        table = _pairs.pair_statistics(
            *given, options.d_cells, options.theta_cells, tiles=tiles, tile=options.tile, **settings
        )
    sums = {name: getattr(table, name) for name in SUMS}
    if len(task.block.pairs) < len(table.n):
        wanted = [
            _index(groups.index(a), groups.index(b), len(groups)) for a, b in task.block.pairs
        ]
        sums = {name: array[wanted] for name, array in sums.items()}
    return {
        "pair": np.array(task.block.pairs, dtype=np.int64).reshape(-1, 2),
        **sums,
        "evaluated": np.array(evaluated),
        "seconds": np.array(time.perf_counter() - began),
    }


def _index(a: int, b: int, n_groups: int) -> int:
    """Row of the groups a <= b in a pair table."""
    return a * n_groups - a * (a + 1) // 2 + b


def _tiles(
    block: PairBlock, label: npt.NDArray[np.int32], groups: list[int], tile: int
) -> tuple[npt.NDArray[np.int64], int]:
    """Tiles of the block's group pairs, as numbers among its points' tiles; and their pairs."""
    tiles = tile_list(label, tile)
    kept = []
    for k, (a, b) in enumerate(block.pairs):
        own = np.flatnonzero((tiles["a"] == groups.index(a)) & (tiles["b"] == groups.index(b)))
        kept.append(own if block.tiles is None else own[block.tiles[k]])
    chosen = np.concatenate(kept)
    return chosen, int(tiles["pairs"][chosen].sum())


POINTS = Format(
    kind="the points of a correlation",
    version=1,
    arrays={
        **dict.fromkeys(("positions", "normals", "hemisphere"), ArrayField("f4", ("N", 3))),
        "group": ArrayField("i4", ("N",)),
    },
)


def write_points(folder: Path, points: Points, hemisphere: npt.NDArray[np.float32]) -> None:
    """Save the points beside the rows for workers; `hemisphere` are the normals of the rows."""
    folder.mkdir(parents=True, exist_ok=True)
    POINTS.write_npz(
        folder / "points.npz",
        {},
        {
            "positions": points.positions,
            "normals": points.normals,
            "group": points.group,
            "hemisphere": hemisphere,
        },
    )


def count_in_worker(task: PairTask) -> Arrays:
    """Run `count` in a worker: reads rows and points from the folder."""
    folder = _shared_folder(task.folder)
    bits = mapped_rows(folder / "rows.npy", "r")
    _, read = POINTS.read_npz(folder / "points.npz")
    points = Points(**{name: read[name] for name in ("positions", "normals", "group")})
    if len(bits) != len(points.group):
        raise POINTS.refusal(folder, f"it must have {len(bits)} points, got {len(points.group)}")
    return count(task, bits, points)


def trace_in_worker(task: RowsTask) -> Arrays:
    """Run `trace` in a worker: opens the scene itself and keeps the newest one."""
    folder = _shared_folder(task.folder)
    scene = _SCENE.get(task.scene, lambda: sources.opened(task.scene))
    if scene.content_hash != task.scene_hash:
        raise ValueError(f"scene {task.scene} is not the one the measurement began with")
    _, points = POINTS.read_npz(folder / "points.npz")
    return trace(task, scene, points["positions"], points["hemisphere"])


_SCENE = Newest()


def _shared_folder(folder: Path | None) -> Path:
    if folder is None or not (folder / "rows.npy").is_file():
        raise ValueError(
            f"directory must be a folder that the executor's workers see, got {folder}"
        )
    return folder

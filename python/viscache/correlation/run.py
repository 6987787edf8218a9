"""Runs one measurement block by block: rows, near pass and far pass."""

from __future__ import annotations

import time
from collections.abc import Callable
from concurrent.futures import Executor
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from viscache.base.array_digests import content_key
from viscache.correlation.bins import Bins
from viscache.correlation.pair_table import SUMS
from viscache.correlation.statistics import Sums
from viscache.correlation.tasks import (
    PairOptions,
    PairTask,
    Points,
    RowsTask,
    count,
    count_in_worker,
)
from viscache.correlation.work import PairBlock, group_pairs, pair_blocks, row_blocks, work_through
from viscache.correlation.work_store import Arrays, FolderStore, MemoryStore, WorkStore

if TYPE_CHECKING:
    import xarray

Report = Callable[[int, int], None]

#: The near pass may count this many pairs, or this fraction of the sampled ones, whichever is more.
#: The rows of near points are scattered in memory, so a near pair costs about 30 times as much as a
#: pair of a tile.
NEAR_PAIRS = 5e6
NEAR_SHARE = 0.03
PILOT = 512


@dataclass(frozen=True, kw_only=True, slots=True)
class Counted:
    """Sums over pairs: `far` over all, or over the fraction `far_share` of them at any distance.

    `near` is over all pairs with d < d_near; None if `far` has all pairs, or without a near pass.
    """

    far: Sums
    near: Sums | None
    d_near: float | None
    far_share: float
    n_pairs: int
    seconds: float


class Run:
    """The blocks of one measurement and their store; the key hashes what determines the rows.

    About `n_pairs` random pairs are counted, and all near ones; None: all pairs. Without a folder
    all is kept in memory; an executor requires one. `report` is called with the numbers of finished
    and of all blocks. `rows_per_block` is the number of points whose rows are traced together.
    """

    def __init__(
        self,
        key: str,
        points: Points,
        bins: Bins,
        options: PairOptions,
        *,
        n_pairs: int | None,
        seed: int,
        folder: Path | None,
        executor: Executor | None,
        threads: int | None,
        report: Report | None,
        rows_per_block: int | None = None,
    ) -> None:
        self.points, self.bins, self.options = points, bins, options
        self.executor, self.threads, self.report = executor, threads, report
        shape = (len(points.group), -(-options.n_directions // 512) * 8)
        self.store: WorkStore
        if folder is None:
            self.folder = None
            # Pages that are never written take no memory
            self.store = MemoryStore(np.zeros(shape, dtype=np.uint64))
        else:
            self.folder = folder / key[:20]
            self.store = FolderStore(self.folder, shape)
        self.d_near = None if n_pairs is None else near_limit(points, bins, n_pairs, seed)
        self.row_blocks = row_blocks(len(points.group), rows_per_block)
        self.pair_tasks = self._pair_tasks(pair_blocks(points.group, n_pairs, seed))
        self.rows_s, self.n_rays, self.batch_rays = 0.0, 0, 0
        self._finished = 0

    def _pair_tasks(self, blocks: list[PairBlock]) -> list[PairTask]:
        common: dict[str, Any] = {
            "folder": self.folder,
            "options": self.options,
            "threads": self.threads,
        }
        tasks = [PairTask(block=block, d_near=None, **common) for block in blocks]
        if self.d_near is not None:
            whole = PairBlock(0, tuple(group_pairs(int(self.points.group.max()) + 1)))
            tasks.insert(0, PairTask(block=whole, d_near=self.d_near, **common))
        return tasks

    def trace_rows(
        self, make: Callable[[int, int], RowsTask], work: Callable[[RowsTask], Arrays]
    ) -> None:
        """Trace the rows that are not in the store; `work` runs here or in a worker."""
        todo = []
        for first, last in self.row_blocks:
            known = self.store.get(_rows_name(first, last), slice(first, last))
            if known is None:
                todo.append(make(first, last))
            else:
                self.n_rays += int(known["n_rays"])
                self.batch_rays += int(known["batch_rays"])
                self._step()
        self.rows_s = 0.0
        work_through(todo, work, self._keep_rows, self.executor)

    def _keep_rows(self, task: RowsTask, result: Arrays) -> None:
        self.store.bits[task.first : task.last] = result.pop("bits")
        self.store.put(_rows_name(task.first, task.last), result, slice(task.first, task.last))
        self.n_rays += int(result["n_rays"])
        self.batch_rays += int(result["batch_rays"])
        self.rows_s += float(result["seconds"])
        self._step()

    def set_rows(self, bits: npt.NDArray[np.uint64]) -> None:
        """Use existing rows instead of tracing."""
        if isinstance(self.store, MemoryStore):
            self.store.bits = bits
        nothing = {"n_rays": np.array(0), "batch_rays": np.array(0), "seconds": np.array(0.0)}
        for first, last in self.row_blocks:
            block = slice(first, last)
            if self.folder is not None and self.store.get(_rows_name(first, last), block) is None:
                self.store.bits[block] = bits[block]
                self.store.put(_rows_name(first, last), nothing, block)
            self._step()

    def count_pairs(self) -> Counted:
        """Count the pairs that are not in the store, and merge all blocks."""
        began = time.perf_counter()
        folder = f"pairs-{self._pairs_key()[:20]}"
        results: dict[str, Arrays] = {}
        todo = []
        for task in self.pair_tasks:
            known = self.store.get(f"{folder}/{task.name}")
            if known is None:
                todo.append(task)
            else:
                results[task.name] = known
                self._step()

        def keep(task: PairTask, result: Arrays) -> None:
            self.store.put(f"{folder}/{task.name}", result)
            results[task.name] = result
            self._step()

        def here(task: PairTask) -> Arrays:
            return count(task, self.store.bits, self.points)

        work = here if self.executor is None else count_in_worker
        work_through(todo, work, keep, self.executor)
        near = results.pop("near", None)
        n = len(self.points.group)
        looked_at = sum(int(result["evaluated"]) for result in results.values())
        return Counted(
            far=merge_blocks(list(results.values())),
            near=None if near is None else merge_blocks([near]),
            d_near=self.d_near,
            far_share=looked_at / (n * (n - 1) / 2),
            n_pairs=looked_at,
            seconds=time.perf_counter() - began,
        )

    def _pairs_key(self) -> str:
        """Content hash of everything that determines the blocks of pairs, given the rows."""
        o = self.options
        blocks = [
            [task.block.pairs, [tiles.tolist() for tiles in task.block.tiles or ()]]
            for task in self.pair_tasks
        ]
        return content_key(
            {
                "d": o.d_cells.tolist(),
                "theta": o.theta_cells.tolist(),
                "domain": o.domain,
                "undefined": o.undefined,
                "min_bits": o.min_bits,
                "n_directions": o.n_directions,
                "tile": o.tile,
                "blocks": blocks,
                "d_near": self.d_near,
            }
        )

    def report_mended(self, dataset: xarray.Dataset) -> None:
        """Attribute "mended": a line for each damaged block that was computed again, if any was."""
        if self.store.mended:
            dataset.attrs["mended"] = "\n".join(self.store.mended)

    def _step(self) -> None:
        self._finished += 1
        if self.report is not None:
            self.report(self._finished, len(self.row_blocks) + len(self.pair_tasks))


def merge_blocks(blocks: list[Arrays]) -> Sums:
    """Merge blocks of different group pairs; the same bytes in any order."""
    pair = np.concatenate([block["pair"] for block in blocks])
    order = np.lexsort((pair[:, 1], pair[:, 0]))
    n, n_undefined, q, high, low = (
        blocks[0][name]
        if len(blocks) == 1
        else np.concatenate([block[name] for block in blocks])[order]
        for name in SUMS
    )
    wide = high.sum(axis=0).astype(object) * 2**32 + low.sum(axis=0).astype(object)
    first, second = pair[order].T
    return Sums(n=n, n_undefined=n_undefined, q=q, q2=wide, first=first, second=second)


def _rows_name(first: int, last: int) -> str:
    return f"rows-{first}-{last}"


def near_limit(points: Points, bins: Bins, sampled: float, seed: int) -> float | None:
    """The largest edge below which all pairs can be counted without costing much, or None.

    Random pairs are rarely near: of 10¹⁰ pairs a few thousand may have d < 0.2. Up to this limit
    all pairs are enumerated instead. The candidates are the edges shared by the table and the slice
    over d, and `slice_d`. The number of pairs below each is estimated from a pilot of 512 points
    against all points.
    """
    from scipy.spatial import cKDTree

    n = len(points.positions)
    rng = np.random.Generator(np.random.Philox(key=np.array([seed, 0x3EA2], dtype=np.uint64)))
    pilot = points.positions[np.sort(rng.permutation(n)[:PILOT])]
    shared = np.intersect1d(bins.d_edges, bins.slice_d_edges)
    candidates = np.union1d(shared[np.isfinite(shared)], [bins.slice_d])
    candidates = candidates[candidates > 0]
    tree = cKDTree(points.positions)
    affordable = max(NEAR_PAIRS, NEAR_SHARE * sampled)
    limit = None
    for candidate in candidates:
        neighbours = tree.query_ball_point(pilot, candidate, return_length=True).mean() - 1
        if n / 2 * neighbours > affordable:
            break
        limit = float(candidate)
    return limit

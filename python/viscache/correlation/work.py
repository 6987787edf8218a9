"""Divides a measurement into blocks that can run anywhere, and runs them."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import FIRST_COMPLETED, Executor, Future, wait
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np
import numpy.typing as npt

from viscache.base.workers import window
from viscache.correlation.pair_tiles import TILE, choose_tiles, tile_list

Task = TypeVar("Task")
Result = TypeVar("Result")

#: Points whose rows are traced together.
ROWS_PER_BLOCK = 2048
#: The batch is faster with many points at a time.
BATCH_ROWS_PER_BLOCK = 1 << 14
#: Approximate number of pairs per block, about a second on one core.
PAIRS_PER_BLOCK = 1 << 27


@dataclass(frozen=True, slots=True, eq=False)
class PairBlock:
    """Group pairs whose pairs are counted together."""

    index: int
    pairs: tuple[tuple[int, int], ...]
    tiles: tuple[npt.NDArray[np.int64], ...] | None = None
    """For each group pair the chosen tiles, counted from 0; None: all tiles."""


def group_pairs(n_groups: int) -> list[tuple[int, int]]:
    """(a, b) with a <= b in order: (0, 0), (0, 1), …, (1, 1), …"""
    return list(itertools.combinations_with_replacement(range(n_groups), 2))


def tile_size(group: npt.NDArray[np.int32], sampled: bool) -> int:
    """Points along a tile; if pairs are sampled, few enough that a group has 8 blocks."""
    if not sampled:
        return TILE
    largest = int(np.bincount(group).max())
    return int(np.clip(-(-largest // 128) * 16, 16, TILE))


def pair_blocks(
    group: npt.NDArray[np.int32], n_pairs: int | None = None, seed: int = 0
) -> list[PairBlock]:
    """All group pairs in order, in blocks of about `PAIRS_PER_BLOCK` pairs.

    With `n_pairs`, about that many in randomly chosen tiles.
    """
    tile = tile_size(group, n_pairs is not None)
    tiles = tile_list(group, tile)
    taken = np.full(len(tiles), n_pairs is None)
    if n_pairs is not None:
        taken[choose_tiles(group, n_pairs, seed, tile)] = True
    blocks: list[PairBlock] = []
    pairs: list[tuple[int, int]] = []
    chosen: list[npt.NDArray[np.int64]] = []
    load = 0
    last = int(group.max()), int(group.max())
    for a, b in group_pairs(last[0] + 1):
        own = (tiles["a"] == a) & (tiles["b"] == b)
        pairs.append((a, b))
        chosen.append(np.flatnonzero(taken[own]))
        load += int(tiles["pairs"][own & taken].sum())
        if load >= PAIRS_PER_BLOCK or (a, b) == last:
            picks = None if n_pairs is None else tuple(chosen)
            blocks.append(PairBlock(len(blocks), tuple(pairs), picks))
            pairs, chosen, load = [], [], 0
    return blocks


def row_blocks(n_points: int, size: int | None = None) -> list[tuple[int, int]]:
    """(first, last + 1) of the points of each block; ROWS_PER_BLOCK points by default."""
    size = size or ROWS_PER_BLOCK
    return [(i, min(i + size, n_points)) for i in range(0, n_points, size)]


def work_through(
    tasks: Iterable[Task],
    work: Callable[[Task], Result],
    keep: Callable[[Task, Result], None],
    executor: Executor | None = None,
) -> None:
    """Run every task, here or in the executor; `keep` is called here as soon as a task is done.

    Finished tasks are kept before an error or Ctrl-C is raised; tasks that have not started are
    dropped.
    """
    if executor is None:
        for task in tasks:
            keep(task, work(task))
        return
    waiting = iter(tasks)
    flying: dict[Future[Result], Task] = {}
    try:
        while True:
            for task in itertools.islice(waiting, max(0, window(executor) - len(flying))):
                flying[executor.submit(work, task)] = task
            if not flying:
                return
            ready, _ = wait(list(flying), timeout=0.5, return_when=FIRST_COMPLETED)
            _keep_all([(flying.pop(f), f) for f in ready], keep)
    finally:
        for future in flying:
            future.cancel()


def _keep_all(done: Sequence[tuple[Task, Future[Any]]], keep: Callable[[Task, Any], None]) -> None:
    failures = []
    for task, future in done:
        error = future.exception()
        if error is None:
            keep(task, future.result())
        else:
            failures.append(error)
    if failures:
        raise failures[0]

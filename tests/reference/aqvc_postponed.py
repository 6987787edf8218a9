"""Postponed rays of the quantized cache (Sec. 4.4) in plain Python, one query at a time."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from reference.aqvc import NEIGHBOURS, Grid, Key, Result, place_all


@dataclass
class Postponed:
    """A ray that waits, and the queries that wait for it."""

    key: tuple[Key, int]
    level: int
    waiting: list[tuple[int, int]]


def postponed(
    grid: Grid,
    eyes: dict,
    levels: Sequence[float],
    exact: NDArray[np.bool_],
    wanted: NDArray[np.bool_],
    runs: Sequence[Sequence[int]],
    queue: int,
    c_w: int,
) -> Result:
    """Sec. 4.4: warps of queue/2 queries; each run of eye points ends with an empty queue."""
    placed = place_all(grid, eyes, levels)
    table: dict[tuple[Key, int], bool] = {}
    out = Result(np.zeros_like(wanted), [0] * len(levels))

    def look_up(i: int, k: int) -> bool | Postponed:
        value = False
        for d, cell in enumerate(placed[i]):
            if d > 0 and cell.key == placed[i][d - 1].key:
                continue
            if (cell.key, k) not in table:
                return Postponed((cell.key, k), d, [(i, k)])
            value = table[cell.key, k]
            near = [table.get((cell.neighbour(*o, grid.tangent), k)) for o in NEIGHBOURS]
            if all(n is None or n == value for n in near):
                break
        return value

    def finish(rays: Sequence[Postponed]) -> None:
        for ray in rays:
            table[ray.key] = bool(exact[ray.waiting[0]])
            out.rays_per_level[ray.level] += 1
            for query in ray.waiting:
                out.visible[query] = table[ray.key]

    for run in runs:
        queries = [(i, int(k)) for i in run for k in np.flatnonzero(wanted[i])]
        entries: list[Postponed] = []
        for first in range(0, len(queries), queue // 2):
            new: list[Postponed] = []
            for query in queries[first : first + queue // 2]:
                found = look_up(*query)
                if isinstance(found, bool):
                    out.visible[query] = found
                    continue
                same = [ray for ray in entries + new if ray.key == found.key]
                if same:
                    same[0].waiting.append(query)
                else:
                    new.append(found)
            if len(new) < c_w:
                entries += new
            else:
                finish(new)
            while len(entries) > queue // 2:
                finish(entries[: queue // 2])
                del entries[: queue // 2]
        finish(entries)
    return out

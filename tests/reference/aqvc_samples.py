"""Samples of each eye point's own through the quantized cache, in NumPy and dictionaries."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from reference.aqvc import (
    NEIGHBOURS,
    Grid,
    Key,
    Placed,
    Result,
    ladder,
    octahedron,
    resolution_environment,
    resolution_light,
)


def direction_key(
    w: NDArray[np.float32], density: float, c_r: float = 1.2, c_l: float = 1.0
) -> Key | None:
    """Eq. 9: i, j, R of a direction; None where it has none."""
    if not np.isfinite(w).all() or not w.any():
        return None
    r = float(ladder(resolution_environment(np.float64(density)) / c_l, c_r))
    i, j = (int(min(r - 1, np.floor(c * r))) for c in octahedron(w))
    return (i, j, int(r))


def surface_key(
    grid: Grid, y: NDArray[np.float32], n: NDArray[np.float32], density: float, c_l: float = 1.0
) -> Key | None:
    """Eq. 7, light side: the surface cell of a point on a light."""
    if not np.isfinite(y).all() or not np.isfinite(n).all() or not n.any():
        return None
    return grid.place(y, n, float(resolution_light(np.float64(density), grid.radius) / c_l)).key


def columns(keys: Sequence[Key | None]) -> list[int]:
    """Numbers of light cells in order of first touch; -1 without a key."""
    numbers: dict[Key, int] = {}
    return [-1 if k is None else numbers.setdefault(k, len(numbers)) for k in keys]


def outward_order(placed: Sequence[Sequence[Placed]], batch: int) -> tuple[list[int], list[int]]:
    """Eye points by rank in their coarsest cell, from its centre outwards, and the ends of runs.

    Rounds are ranks 0, 1, 2–3, 4–7, …; inside a round eye points keep their order. A run has at
    most `batch` eye points and ends with its round.
    """
    inside: dict[Key, list[int]] = {}
    for i, steps in enumerate(placed):
        inside.setdefault(steps[0].key, []).append(i)
    rounds: dict[int, list[int]] = {}
    for members in inside.values():
        members.sort(key=lambda i: (np.float32(placed[i][0].distance2), i))
        for rank, i in enumerate(members):
            rounds.setdefault(rank.bit_length(), []).append(i)
    order: list[int] = []
    ends: list[int] = []
    for k in sorted(rounds):
        part = sorted(rounds[k])
        ends += [len(order) + min(len(part), e + batch) for e in range(0, len(part), batch)]
        order += part
    return order, ends


def own_samples(
    grid: Grid,
    placed: Sequence[Sequence[Placed]],
    order: Sequence[int],
    run_end: Sequence[int],
    sample_eye: NDArray[np.int64],
    column: Sequence[int],
    exact: NDArray[np.bool_],
) -> Result:
    """Alg. 2 on samples, each run of eye points against the table as it was before the run.

    Samples of one eye point in one column ask once; the first of them is traced.
    """
    table: dict[tuple[Key, int], bool] = {}
    visible = np.zeros(len(column), bool)
    out = Result(visible, [0] * max(len(steps) for steps in placed))
    first = 0
    for end in run_end:
        pending: dict[tuple[Key, int], bool] = {}
        waiting: list[tuple[list[int], tuple[Key, int]]] = []
        for eye in order[first:end]:
            steps = placed[eye]
            asked: dict[int, list[int]] = {}
            for i in np.flatnonzero(sample_eye == eye).tolist():
                asked.setdefault(column[i], []).append(i)
            levels = [d for d in range(len(steps)) if d == 0 or steps[d].key != steps[d - 1].key]
            for k, samples in asked.items():
                for d in levels:
                    at = (steps[d].key, k)
                    value = table.get(at)
                    if value is None:
                        if at not in pending:
                            pending[at] = bool(exact[samples[0]])
                            out.rays_per_level[d] += 1
                        waiting.append((samples, at))
                        break
                    near = [
                        table.get((steps[d].neighbour(*o, grid.tangent), k)) for o in NEIGHBOURS
                    ]
                    agree = all(n is None or n == value for n in near)
                    if d == levels[-1] or agree:
                        visible[samples] = value
                        break
        table |= pending
        for samples, at in waiting:
            visible[samples] = pending[at]
        first = end
    return out

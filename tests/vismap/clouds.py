"""Points that searches are tried on, and the search by brute force."""

from typing import Any

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[Any]
N = 10_000


def clouds() -> dict[str, Array]:
    random = np.random.default_rng(5)
    line = np.zeros((N, 3))
    line[:, 1] = np.linspace(0, 1, N)
    return {
        "random": random.random((N, 3)),
        "collinear": line,
        "grid": random.integers(0, 12, (N, 3)) / 12,
        "duplicates": random.random((50, 3))[random.integers(0, 50, N)],
        "clusters": random.random((20, 3)).repeat(N // 20, 0) + random.normal(0, 1e-4, (N, 3)),
        "halving": np.stack([0.5 ** (np.arange(N) % 120), np.zeros(N), np.zeros(N)], 1),
        "far away": random.random((N, 3)) + 1e5,
    }


def nearest(points: Array, at: Array, radius: float, m: int) -> list[int]:
    """In float32, term by term; ties by id."""
    to = points - at
    d2 = (to[:, 0] * to[:, 0] + to[:, 1] * to[:, 1]) + to[:, 2] * to[:, 2]
    inside = np.flatnonzero(d2 < np.float32(radius) * np.float32(radius))
    order = np.lexsort((inside, d2[inside]))
    return [int(i) for i in inside[order[:m]]]
